"""Separable natural evolution strategy: every weight has a step size of its own.

Wierstra, Schaul, Glasmachers, Sun, Peters & Schmidhuber (2014), "Natural evolution strategies",
JMLR 15:949-980, https://jmlr.org/papers/v15/wierstra14a.html, algorithm 6; defaults of table 1.
"""

import functools
import math
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from mjxwalk.strategies import checks, vectors
from mjxwalk.strategies.base import Genotype, ScalarLike, Strategy, Tree
from mjxwalk.strategies.metrics import SearchMetrics
from mjxwalk.strategies.normal_search import normal_search
from mjxwalk.strategies.ranks import nes_utilities

MEAN_LEARNING_RATE = 1.0  # Wierstra et al. (2014), table 1


class SNESState(NamedTuple):
    """State between generations.

    Attributes:
      mean: what the population is drawn around, as one vector; see `vectors.unflatten`.
      sigma: standard deviation of each weight.
      template: genotype that the search started from.
      generation: number of the generation to be evaluated next.
    """

    mean: Float[Array, " dim"]
    sigma: Float[Array, " dim"]
    template: Genotype
    generation: Int[Array, ""]


def snes(
    *,
    population_size: int,
    sigma: Tree,
    mean_learning_rate: ScalarLike = MEAN_LEARNING_RATE,
    sigma_learning_rate: ScalarLike | None = None,
) -> Strategy[SNESState, SearchMetrics]:
    """Returns the separable natural evolution strategy of Wierstra et al. (2014), algorithm 6.

    Args:
      population_size: genotypes in a generation.
      sigma: standard deviation of generation 0, in units of the weights; one value, or a pytree
        prefix of the template.
      mean_learning_rate: share of the natural gradient that the mean follows.
      sigma_learning_rate: the same of the step sizes; None for `default_sigma_learning_rate`.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_numbers("mean_learning_rate", mean_learning_rate, above=0.0)
    if sigma_learning_rate is not None:
        checks.check_numbers("sigma_learning_rate", sigma_learning_rate, minimum=0.0)
    return normal_search(
        population_size=population_size,
        sigma=sigma,
        init=_init,
        deviations=lambda state: state.sigma,
        tell=functools.partial(_tell, mean_learning_rate, sigma_learning_rate),
    )


def default_sigma_learning_rate(num_weights: int) -> float:
    """Returns the learning rate of step sizes in table 1 of Wierstra et al. (2014)."""
    return (3 + math.log(num_weights)) / (5 * math.sqrt(num_weights))


def _init(template: Genotype, deviations: Float[Array, " dim"]) -> SNESState:
    return SNESState(
        mean=vectors.flatten(template),
        sigma=deviations,
        template=template,
        generation=jnp.zeros((), jnp.int32),
    )


def _tell(
    mean_learning_rate: ScalarLike,
    sigma_learning_rate: ScalarLike | None,
    genotypes: Float[Array, "pop dim"],
    fitness: Float[Array, " pop"],
    state: SNESState,
) -> SNESState:
    utilities = nes_utilities(fitness).astype(state.mean.dtype)
    noise = (genotypes - state.mean) / state.sigma
    if sigma_learning_rate is None:
        sigma_learning_rate = default_sigma_learning_rate(state.mean.size)
    step = state.sigma * (utilities @ noise)
    growth = utilities @ (noise**2 - 1)
    return state._replace(
        mean=state.mean + mean_learning_rate * step,
        sigma=vectors.bound_sigma(state.sigma * jnp.exp(sigma_learning_rate / 2 * growth)),
        generation=state.generation + 1,
    )
