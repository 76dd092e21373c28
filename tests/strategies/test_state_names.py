"""Names of a state's arrays: checkpoints hold them, and runs of earlier versions have to resume."""

from typing import Any

import jax
import jax.numpy as jnp
import pytest

from mjxwalk import strategies
from mjxwalk.runs.trees import flatten

SIGMA = {"sigma": 0.5}
SIGMAS = {"sigma": 0.5, "initial_sigma": 0.5}
BOUNDS = {"lower": -1.0, "upper": 1.0}
SEARCH = "mean template generation"
CMA = f"{SEARCH} sigma paths.sigma paths.covariance"
GENERATIONS = "population generation best_genotype best_fitness"


@pytest.mark.parametrize(
    ("name", "options", "names"),
    [
        ("ars", SIGMA, SEARCH),
        ("openai-es", SIGMA, SEARCH),
        ("pgpe", SIGMA, f"{SEARCH} sigma"),
        ("snes", SIGMA, f"{SEARCH} sigma"),
        ("xnes", SIGMA, f"{SEARCH} sigma axes"),
        ("cma-es", SIGMA, f"{CMA} covariance root whitener"),
        ("sep-cma-es", SIGMA, f"{CMA} lengths"),
        ("deep-ga", SIGMAS, GENERATIONS),
        ("truncation-ga", BOUNDS, GENERATIONS),
        ("two-point-ga", BOUNDS, GENERATIONS),
        ("self-adaptive-ga", SIGMAS, f"{GENERATIONS} mask learning_rates best_mask"),
        ("pattern-search", {}, "centre best_fitness mesh poll order generation finished"),
    ],
)
def test_they_are_those_of_earlier_versions(name: str, options: dict[str, Any], names: str):
    strategy = strategies.make(name, population_size=4, **options)
    state = strategy.init(jax.random.key(0), jnp.zeros(3))
    # An optimiser's are optax's own.
    got = {name for name in flatten(state) if not name.startswith("optimizer_state.")}
    assert got == set(names.split())
