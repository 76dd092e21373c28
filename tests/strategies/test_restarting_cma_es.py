"""Tests of CMA-ES with restarts, of when a search ends, and of what follows it."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.strategies import (
    bipop_cma_es,
    cma_es,
    evolution_paths,
    ipop_cma_es,
    starts,
)
from mjxwalk.strategies.evolution_paths import cma_rates
from mjxwalk.strategies.search_ends import has_ended

SIZE = 6
START = jnp.full(3, 2.5)


def _jitted(strategy: Any) -> tuple[Any, Any, Any]:
    return strategy.init, jax.jit(strategy.ask), jax.jit(strategy.tell)


@functools.cache
def _ipop() -> tuple[Any, Any, Any]:
    return _jitted(ipop_cma_es(population_size=SIZE, sigma=0.5, max_doublings=1))


def _rastrigin(population: jax.Array) -> jax.Array:
    return jnp.sum(population**2 - 10 * jnp.cos(2 * jnp.pi * population) + 10, axis=1)


def test_the_first_start_is_plain_cma_es():
    _, ask, tell = _ipop()
    _, _, plain_tell = _jitted(cma_es(population_size=SIZE, sigma=0.5))
    state, plain = (
        _ipop()[0](jax.random.key(0), START),
        cma_es(population_size=SIZE, sigma=0.5).init(jax.random.key(0), START),
    )
    for key in jax.random.split(jax.random.key(1), 4):
        population, state = ask(key, state)
        fitness = -_rastrigin(population)
        state, _ = tell(key, population, fitness, state)
        plain, _ = plain_tell(key, population, fitness, plain)
    # Sums over more rows, of which some have no weight, round otherwise.
    np.testing.assert_allclose(state.inner.mean, plain.mean, rtol=1e-4)
    np.testing.assert_allclose(state.inner.covariance, plain.covariance, rtol=1e-4, atol=1e-5)


def test_a_generation_of_twice_the_size_takes_two_calls_and_is_that_of_cma_es():
    init, ask, tell = _ipop()
    state = init(jax.random.key(0), START)
    state = state._replace(
        budget=state.budget._replace(doublings=jnp.asarray(1, jnp.int32)),
        fitness=jnp.full_like(state.fitness, 1e9),  # as a larger generation left it
    )
    told: list[Any] = []
    for index in range(2):
        population, state = ask(jax.random.key(index), state)
        fitness = (-_rastrigin(population)).at[0].set(jnp.nan)
        told.append((population, fitness))
        before = state
        state, metrics = tell(jax.random.key(9), population, fitness, state)
        assert int(metrics.generation_size) == 2 * SIZE
        assert int(state.inner.generation) == index
    population, fitness = (jnp.concatenate(parts) for parts in zip(*told, strict=True))
    _, _, tell_twice = _jitted(cma_es(population_size=2 * SIZE, sigma=0.5))
    expected, _ = tell_twice(jax.random.key(9), population, fitness, before.inner)  # pyright: ignore
    np.testing.assert_allclose(state.inner.mean, expected.mean, rtol=1e-4)
    np.testing.assert_allclose(state.inner.covariance, expected.covariance, rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(state.inner.sigma, expected.sigma, rtol=1e-4)


def test_constants_are_those_of_each_size():
    got = evolution_paths.rates_of_start(SIZE, 3, jnp.asarray(1), most=2, separable=False)
    expected = cma_rates(2 * SIZE, 3)
    np.testing.assert_allclose(got.weights[: 2 * SIZE], expected.weights, rtol=1e-6)
    assert not np.any(got.weights[2 * SIZE :])
    np.testing.assert_allclose(got.rank_many, expected.rank_many, rtol=1e-6)


def test_restarts_with_more_get_out_of_local_minima():
    strategy = ipop_cma_es(population_size=SIZE, sigma=0.5, start_sigma=2.0, max_doublings=4)

    @jax.jit
    def run(key: jax.Array) -> Any:
        def call(state: Any, key: jax.Array) -> tuple[Any, Any]:
            key_ask, key_tell = jax.random.split(key)
            population, state = strategy.ask(key_ask, state)
            cost = _rastrigin(population)
            state, metrics = strategy.tell(key_tell, population, -cost, state)
            return state, (jnp.min(cost), metrics.num_restarts, metrics.generation_size)

        return jax.lax.scan(call, strategy.init(key, START), jax.random.split(key, 400))[1]

    cost, num_restarts, size = (np.asarray(part) for part in run(jax.random.key(4)))
    assert cost[num_restarts == 0].min() > 0.5  # the first ends in a local minimum
    assert cost.min() < 1e-3
    assert np.all(size == SIZE * 2 ** num_restarts.clip(max=4))
    assert num_restarts[-1] >= 2


@pytest.mark.parametrize("values", [0.0, -np.inf, np.nan], ids=["flat", "all -inf", "all NaN"])
def test_flat_fitness_ends_a_start_after_as_many_generations_as_pycma_waits(values: float):
    init, ask, tell = _ipop()
    state = init(jax.random.key(0), START)
    ends: list[int] = []
    for call in range(26):
        population, state = ask(jax.random.key(call), state)
        state, _ = tell(jax.random.key(call), population, jnp.full(SIZE, values), state)
        ends.append(int(state.budget.num_restarts))
    # 10 + 30 n / population = 25
    assert ends[23:] == [0, 1, 1]
    assert int(state.budget.doublings) == 1 and int(state.inner.generation) == 0
    assert jnp.all(state.inner.mean != START)


def test_a_search_ends_where_its_steps_have_no_effect():
    state = cma_es(population_size=SIZE, sigma=0.5).init(jax.random.key(0), START)
    history = jnp.arange(25.0)
    ended = jax.jit(lambda s: has_ended(s, jnp.asarray(0.5), history, jnp.asarray(25)))
    assert not ended(state)
    assert ended(state._replace(sigma=jnp.asarray(1e-8)))
    at_zero = state._replace(mean=jnp.zeros(3))
    assert not ended(at_zero._replace(sigma=jnp.asarray(1e-8)))
    assert ended(at_zero._replace(sigma=jnp.asarray(1e-13)))
    assert ended(state._replace(root=state.root.at[0, 0].set(1e8)))


def _budget(**changes: Any) -> starts.Budget:
    values = {name: jnp.asarray(value) for name, value in changes.items()}
    return starts.first()._replace(**values)


def test_bipop_starts_small_populations_until_they_have_had_as_much():
    following = functools.partial(starts.following, max_doublings=9, has_small=True)
    uniform = jnp.array([0.9, 0.5])
    large, factor = following(_budget(small_calls=30), uniform)
    assert not large.is_small and int(large.doublings) == 1 and float(factor) == 1
    behind = _budget(small_calls=30, large_calls=70, most_doublings=3)
    small, factor = following(behind, uniform)
    assert small.is_small and int(small.most_doublings) == 3
    assert int(small.doublings) == 2  # 3 x 0.81, rounded down
    np.testing.assert_allclose(factor, 0.1, rtol=1e-6)
    assert not following(behind, uniform, has_small=False)[0].is_small
    running = _budget(large_calls=70, num_restarts=2, calls=34)
    assert not starts.is_over(running)
    assert starts.is_over(running._replace(calls=jnp.asarray(35)))
    assert not starts.is_over(running._replace(calls=jnp.asarray(99), num_restarts=jnp.asarray(0)))


def test_wrong_settings_are_refused():
    with pytest.raises(ValueError, match="max_doublings must be a whole number >= 0, got -1"):
        ipop_cma_es(population_size=4, sigma=1.0, max_doublings=-1)
    with pytest.raises(ValueError, match="start_sigma must be finite and >= 0.0, got -1.0"):
        bipop_cma_es(population_size=4, sigma=1.0, start_sigma=-1.0)
