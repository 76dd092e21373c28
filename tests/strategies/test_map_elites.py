"""Tests of MAP-Elites, by hand."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compiled import compiled

from mjxwalk import strategies
from mjxwalk.strategies.map_elites import find_cells, pick_filled

NAN = jnp.nan


@functools.cache
def _grid(population_size: int = 4) -> strategies.MapElites:
    grid = strategies.map_elites(
        population_size=population_size,
        initial_sigma=1.0,
        lower=(0.0, 0.0),
        upper=(1.0, 2.0),
        num_bins=(2, 4),
    )
    return compiled(grid)


def test_cells_are_counted_in_rows_and_outside_is_the_outermost():
    behaviour = jnp.array([[0.1, 0.1], [0.6, 1.9], [-5.0, 99.0], [1.0, 0.5]])
    cells = find_cells(behaviour, jnp.zeros(2), jnp.array([1.0, 2.0]), (2, 4))
    np.testing.assert_array_equal(cells, [0, 7, 3, 5])


def test_the_fittest_of_a_cell_stays_and_nan_gets_none():
    strategy = _grid()
    state = strategy.init(jax.random.key(0), jnp.zeros(1))
    population = jnp.array([[1.0], [2.0], [3.0], [4.0]])
    here = jnp.array([[0.1, 0.1], [0.1, 0.1], [0.9, 1.9], [0.6, 0.1]])
    fitness = jnp.array([1.0, 5.0, NAN, -2.0])
    state, metrics = strategy.tell_behaviour(jax.random.key(1), population, fitness, here, state)
    assert int(metrics.num_filled) == 2 and float(metrics.archive_fitness) == 5.0
    np.testing.assert_array_equal(state.genotypes[jnp.array([0, 4]), 0], [2.0, 4.0])
    worse = jnp.full(4, 4.0)
    state, _ = strategy.tell_behaviour(jax.random.key(2), population * 10, worse, here, state)
    np.testing.assert_array_equal(
        state.fitness, [5, -np.inf, -np.inf, -np.inf, 4, -np.inf, -np.inf, 4]
    )
    assert float(state.genotypes[7, 0]) == 30.0 and float(state.genotypes[4, 0]) == 40.0


def test_only_filled_cells_are_parents():
    fitness = jnp.array([-jnp.inf, 1.0, -jnp.inf, 2.0])
    draws = jnp.array([[0.0, 0.49], [0.5, 0.999]])
    first, second = jax.jit(pick_filled)(fitness, draws)
    np.testing.assert_array_equal(first, [1, 3])
    np.testing.assert_array_equal(second, [1, 3])


def test_the_archive_fills():
    strategy = _grid(16)
    ask, tell = strategy.ask, strategy.tell_behaviour
    state = strategy.init(jax.random.key(0), jnp.zeros(2))
    for generation in range(20):
        population, state = ask(jax.random.key(generation), state)
        state, metrics = tell(
            jax.random.key(0), population, -jnp.sum(population**2, axis=1), population, state
        )
    assert int(metrics.num_filled) >= 6  # pyright: ignore[reportPossiblyUnboundVariable]


def test_what_does_not_fit_is_refused():
    with pytest.raises(ValueError, match=r"upper must be above lower \(1.0\), got 0.5"):
        strategies.map_elites(
            population_size=4, initial_sigma=1.0, lower=(1.0,), upper=(0.5,), num_bins=(3,)
        )
    with pytest.raises(ValueError, match="template must be an array of floats"):
        _grid().init(jax.random.key(0), np.zeros(1, int))


def test_it_is_no_strategy_as_it_cannot_be_told_fitness_alone():
    assert not isinstance(_grid(), strategies.Strategy)
    assert not hasattr(_grid(), "tell")
