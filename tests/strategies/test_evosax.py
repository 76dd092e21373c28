"""Tests of the adapters, in loops as evosax and as we write them."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from evosax.algorithms import SNES, SimpleGA  # pyright: ignore

from mjxwalk import strategies

TEMPLATE = {"w": jnp.ones((2, 2))}


def _cost(population: dict[str, jax.Array]) -> jax.Array:
    return jnp.sum(population["w"] ** 2, axis=(1, 2))


@pytest.mark.parametrize("name", ["distribution", "population"])
def test_an_algorithm_of_evosax_maximises_and_survives_nan(name: str):
    if name == "distribution":
        strategy = strategies.from_evosax(SNES(8, TEMPLATE))
    else:
        strategy = strategies.from_evosax(
            SimpleGA(8, TEMPLATE, std_schedule=lambda generation: 0.1), initial_sigma=0.5
        )

    @jax.jit
    def run(key: jax.Array) -> jax.Array:
        def generation(state: Any, key: jax.Array) -> tuple[Any, jax.Array]:
            key_ask, key_tell = jax.random.split(key)
            population, state = strategy.ask(key_ask, state)
            fitness = (-_cost(population)).at[0].set(jnp.nan)
            state, _ = strategy.tell(key_tell, population, fitness, state)
            return state, jnp.nanmax(fitness)

        state = strategy.init(key, TEMPLATE)
        return jax.lax.scan(generation, state, jax.random.split(key, 60))[1]

    fitness = run(jax.random.key(0))
    assert jnp.median(fitness[-5:]) > 0.5 * jnp.median(fitness[:5])


def test_an_algorithm_for_another_template_is_refused():
    strategy = strategies.from_evosax(SNES(8, TEMPLATE))
    with pytest.raises(ValueError, match="template must be like the solution"):
        strategy.init(jax.random.key(0), {"w": jnp.ones(4)})
    with pytest.raises(ValueError, match="initial_sigma must be"):
        strategies.from_evosax(SimpleGA(8, TEMPLATE))


def test_ours_runs_in_a_loop_of_evosax_and_minimises():
    algorithm = strategies.to_evosax(strategies.snes(population_size=8, sigma=1.0), TEMPLATE)
    params = algorithm.default_params
    state = algorithm.init(jax.random.key(0), TEMPLATE, params)
    ask, tell = jax.jit(algorithm.ask), jax.jit(algorithm.tell)
    for key in jax.random.split(jax.random.key(1), 40):
        key_ask, key_tell = jax.random.split(key)
        population, state = ask(key_ask, state, params)
        state, metrics = tell(key_tell, population, _cost(population), state, params)
    assert algorithm.num_dims == 4 and algorithm.population_size == 8
    assert metrics["best_fitness"] < 0.05  # pyright: ignore[reportPossiblyUnboundVariable]
    np.testing.assert_allclose(
        _cost(jax.tree.map(lambda leaf: leaf[None], state.best_solution))[0],
        state.best_fitness,
        rtol=1e-6,
    )
