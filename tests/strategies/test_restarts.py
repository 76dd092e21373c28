"""Tests of restarts."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compiled import compiled

from mjxwalk.strategies import Strategy, self_adaptive_ga, with_restarts

TEMPLATE = {"w": jnp.zeros(3)}


def plain() -> Strategy[Any, Any]:
    return self_adaptive_ga(population_size=6, sigma=0.1, initial_sigma=1.0)


def evolved(strategy: Strategy[Any, Any], fitness_of_generations: list[Any]) -> list[Any]:
    strategy = compiled(strategy)
    state = strategy.init(jax.random.key(0), TEMPLATE)
    states = [state]
    for generation, fitness in enumerate(fitness_of_generations):
        key_ask, key_tell = jax.random.split(jax.random.key(generation + 1))
        population, state = strategy.ask(key_ask, state)
        state, _ = strategy.tell(key_tell, population, jnp.asarray(fitness, jnp.float32), state)
        states.append(state)
    return states


def test_a_population_that_gets_nowhere_starts_anew_at_the_given_age() -> None:
    low = [0.0] * 6
    states = evolved(with_restarts(plain(), after=3, below=1.0), [low] * 7)
    assert [int(state.num_restarts) for state in states] == [0, 0, 0, 1, 1, 1, 2, 2]
    assert [int(state.age) for state in states] == [0, 1, 2, 0, 1, 2, 0, 1]
    first, second, third = (states[i].inner.population["w"] for i in (0, 3, 6))
    assert not np.array_equal(first, second) and not np.array_equal(second, third)
    assert int(states[3].inner.generation) == 0


def test_one_that_has_passed_the_mark_is_never_restarted() -> None:
    low, high = [0.0] * 6, [0.0, 2.0, 0.0, np.nan, -np.inf, 0.0]
    states = evolved(with_restarts(plain(), after=3, below=1.0), [low, high, low, low, low, low])
    assert int(states[-1].num_restarts) == 0 and int(states[-1].age) == 6
    assert float(states[-1].best_fitness) == 2.0


def test_even_a_good_one_starts_anew_at_the_greatest_age() -> None:
    high = [2.0] * 6
    states = evolved(with_restarts(plain(), after=1, below=1.0, max_age=3), [high] * 4)
    assert [int(state.age) for state in states] == [0, 1, 2, 0, 1]


def test_nan_fitness_is_nowhere() -> None:
    states = evolved(with_restarts(plain(), after=1, below=-1e30), [[np.nan] * 6])
    assert int(states[-1].num_restarts) == 1


def test_between_restarts_it_is_the_strategy_itself() -> None:
    fitness = [[1.0, 5.0, 3.0, 2.0, 4.0, 0.0]] * 2
    wrapped = evolved(with_restarts(plain(), after=9, below=0.0), fitness)[-1].inner
    strategy = compiled(plain())
    state = strategy.init(jax.random.key(0), TEMPLATE)
    for generation, values in enumerate(fitness):
        key_ask, key_tell = jax.random.split(jax.random.key(generation + 1))
        population, state = strategy.ask(key_ask, state)
        inner_key = jax.random.split(key_tell)[0]
        state, _ = strategy.tell(inner_key, population, jnp.asarray(values), state)
    np.testing.assert_allclose(wrapped.population["w"], state.population["w"], rtol=1e-6)


def test_an_age_of_zero_is_refused() -> None:
    with pytest.raises(ValueError, match="after"):
        with_restarts(plain(), after=0, below=1.0)
    with pytest.raises(ValueError, match="max_age"):
        with_restarts(plain(), after=5, below=1.0, max_age=5)
