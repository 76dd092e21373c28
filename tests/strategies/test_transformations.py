"""Strategies under vmap over hyper-parameters, in bfloat16, and with their population sharded."""

import json
import subprocess
import sys
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import strategies

SEARCHES = ["openai-es", "ars", "pgpe", "snes", "xnes", "cma-es", "sep-cma-es"]
SHARDED = """
import json, sys
import jax
jax.config.update("jax_num_cpu_devices", 8)
import jax.numpy as jnp
from jax.sharding import AxisType, NamedSharding, PartitionSpec
from mjxwalk import strategies
mesh = jax.make_mesh((int(sys.argv[1]),), ("pop",), axis_types=(AxisType.Auto,))
spread = NamedSharding(mesh, PartitionSpec("pop"))
ends = {}
for name, options in json.loads(sys.argv[2]).items():
    strategy = strategies.make(name, population_size=16, **options)
    def run(key, strategy=strategy):
        state = strategy.init(key, jnp.ones(4))
        for generation in range(3):
            key_ask, key_tell = jax.random.split(jax.random.fold_in(key, generation))
            population, state = strategy.ask(key_ask, state)
            population = jax.lax.with_sharding_constraint(population, spread)
            fitness = -jnp.sum(population**2, axis=1)
            state, _ = strategy.tell(key_tell, population, fitness, state)
        return strategy.ask(key, state)[0]
    population = jax.jit(run, out_shardings=spread)(jax.random.key(0))
    assert len(population.sharding.device_set) == int(sys.argv[1])
    ends[name] = population.tolist()
print(json.dumps(ends))
"""


@pytest.mark.parametrize("name", ["openai-es", "snes", "cma-es", "deep-ga"])
def test_a_sweep_of_64_settings_is_one_call(name: str):
    options = {"initial_sigma": 0.1} if name == "deep-ga" else {}

    @jax.jit
    @jax.vmap
    def second(sigma: Any) -> Any:
        strategy = strategies.make(name, population_size=4, sigma=sigma, **options)
        state = strategy.init(jax.random.key(0), jnp.zeros(2))
        population, state = strategy.ask(jax.random.key(1), state)
        fitness = -jnp.sum(population**2, axis=1)
        state, _ = strategy.tell(jax.random.key(2), population, fitness, state)
        return strategy.ask(jax.random.key(3), state)[0]

    populations = second(jnp.linspace(0.1, 2.0, 64))
    assert populations.shape == (64, 4, 2)
    spread = np.asarray(jnp.std(populations, axis=1)).mean(axis=1)
    assert spread[-1] > 4 * spread[0]


@pytest.mark.parametrize("name", SEARCHES)
def test_a_population_of_bfloat16_moves_by_less_than_its_last_bit(name: str):
    strategy = strategies.make(name, population_size=8, sigma=0.5)

    @jax.jit
    def run(key: Any) -> Any:
        state = strategy.init(key, jnp.full(3, 1.0, jnp.bfloat16))
        population, state = strategy.ask(key, state)
        state, _ = strategy.tell(key, population, jnp.arange(8.0), state)
        return population, state.mean

    population, mean = run(jax.random.key(0))
    assert population.dtype == jnp.bfloat16
    # The search's own mean has more digits than the population can show.
    assert mean.dtype == jnp.float32
    assert jnp.any(mean != mean.astype(jnp.bfloat16).astype(jnp.float32))


@pytest.mark.slow
def test_a_population_over_eight_devices_is_that_of_one():
    options: dict[str, Any] = {name: {"sigma": 0.5} for name in SEARCHES}
    options["deep-ga"] = {"sigma": 0.1, "initial_sigma": 0.5}
    options["truncation-ga"] = {"lower": -1.0, "upper": 1.0}
    ends = [
        json.loads(
            subprocess.run(
                [sys.executable, "-c", SHARDED, str(devices), json.dumps(options)],
                capture_output=True,
                check=True,
                text=True,
            ).stdout
        )
        for devices in (1, 8)
    ]
    for name in options:
        one, eight = (np.asarray(end[name]) for end in ends)
        if name.endswith("-ga"):
            np.testing.assert_array_equal(eight, one)
        # Sums over the population are taken in another order, in each of three generations.
        np.testing.assert_allclose(eight, one, rtol=1e-4, atol=1e-5)
