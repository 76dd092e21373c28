"""Polls and meshes by hand, a quadratic, Rosenbrock's valley, and the hybrid with the GA."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compiled import compiled
from scipy.optimize import rosen

from mjxwalk.strategies import Strategy, hybrid_ga, pattern_search
from mjxwalk.strategies.pattern_search import poll_offset

ORDER = jnp.arange(4)


def _maximise(strategy: Strategy[Any, Any], start: Any, function: Any, generations: int) -> Any:
    """Returns the last state of a search for the lowest value of a function of a vector."""

    def generation(state: Any, key: Any) -> tuple[Any, Any]:
        key_ask, key_tell = jax.random.split(key)
        population, state = strategy.ask(key_ask, state)
        return strategy.tell(key_tell, population, -jax.vmap(function)(population), state)

    keys = jax.random.split(jax.random.key(1), generations)

    @jax.jit
    def run(start: Any) -> Any:
        state = strategy.init(jax.random.key(0), start)
        return jax.lax.scan(generation, state, keys)

    return run(start)


def _rosenbrock(x: Any) -> Any:
    return jnp.sum(100.0 * (x[1:] - x[:-1] ** 2) ** 2 + (1.0 - x[:-1]) ** 2)


def test_polls_go_both_ways_along_every_axis_and_then_on_a_finer_mesh():
    """By hand, of two weights."""
    polls = jnp.array([-1, 0, 1, 2, 3, 4, 9])
    offsets, mesh = jax.vmap(lambda n: poll_offset(n, ORDER, jnp.array([1.0, 3.0]), 0.5))(polls)
    np.testing.assert_allclose(
        offsets, [[0, 0], [1, 0], [-1, 0], [0, 3], [0, -3], [0.5, 0], [-0.25, 0]]
    )
    np.testing.assert_allclose(mesh, [1, 1, 1, 1, 1, 0.5, 0.25])


@functools.cache
def _search(**options: Any) -> Any:
    return compiled(pattern_search(**options))


def _told(values: list[float], population_size: int = 5, **options: float) -> tuple[Any, Any, Any]:
    """Returns the state and the polls of the first generation, and the state after its fitness."""
    strategy = _search(population_size=population_size, **options)
    state = strategy.init(jax.random.key(0), jnp.zeros(2))
    population, state = strategy.ask(jax.random.key(1), state)
    return (
        state,
        population,
        strategy.tell(jax.random.key(2), population, jnp.array(values), state)[0],
    )


def test_a_poll_that_is_better_becomes_the_centre_and_doubles_the_mesh():
    _, population, after = _told([1.0, 0.0, 3.0, 2.0, 0.0])
    np.testing.assert_array_equal(population[0], [0.0, 0.0])
    np.testing.assert_array_equal(after.centre, population[2])
    assert after.mesh == 2.0
    assert after.poll == 0
    assert after.best_fitness == 3.0


def test_polls_along_all_directions_that_fail_halve_the_mesh():
    # The centre and four polls, which are all directions of two weights.
    _, _, after = _told([3.0, 0.0, 1.0, np.nan, 3.0])
    np.testing.assert_array_equal(after.centre, [0.0, 0.0])
    assert after.mesh == 0.5
    assert after.poll == 0
    assert after.best_fitness == 3.0


def test_a_small_population_polls_on_where_it_stopped():
    before, _, after = _told([3.0, 0.0, 1.0], population_size=3)
    assert after.mesh == 1.0
    assert after.poll == 2
    np.testing.assert_array_equal(after.order, before.order)


def test_a_large_population_tries_finer_meshes_at_once_and_goes_on_from_the_one_that_was_better():
    # Place 6 is poll 5: the second of the mesh of a half, which expansion makes 1 again.
    _, population, after = _told([0.0] * 6 + [5.0] + [0.0] * 2, population_size=9)
    assert np.abs(population[6]).sum() == 0.5
    np.testing.assert_array_equal(after.centre, population[6])
    assert after.mesh == 1.0
    # All of them failed: two levels down.
    assert _told([1.0] + [0.0] * 8, population_size=9)[2].mesh == 0.25


def test_a_mesh_below_its_limit_ends_the_search_and_stays():
    _, _, after = _told([3.0, 0.0, 1.0, 0.0, 0.0], smallest_mesh=0.6)
    assert after.finished
    assert after.mesh == pytest.approx(0.6)
    assert not _told([3.0, 0.0, 1.0, 0.0, 0.0], smallest_mesh=0.5)[2].finished


def test_polls_stop_at_the_bounds():
    strategy = _search(population_size=5, lower=-0.25, upper=0.5)
    population, _ = strategy.ask(jax.random.key(1), strategy.init(jax.random.key(0), jnp.zeros(2)))
    assert population.min() == -0.25
    assert population.max() == 0.5


@pytest.mark.parametrize("population_size", [3, 12, 100])
def test_a_quadratic_is_solved_to_the_mesh(population_size: int):
    target = jnp.array([1.3, -2.7, 0.1, 5.0, -0.01, 3.3])
    weight = jnp.array([1.0, 4.0, 0.5, 2.0, 10.0, 1.0])
    strategy = pattern_search(population_size=population_size)
    state, metrics = _maximise(
        strategy, jnp.zeros(6), lambda x: jnp.sum(weight * (x - target) ** 2), 600
    )
    # A mesh of 2^-10 is what single precision can tell apart here.
    np.testing.assert_allclose(state.centre, target, atol=2e-3)
    best = np.maximum.accumulate(np.asarray(metrics.fitness.best_fitness))
    assert float(state.best_fitness) == best[-1]


def test_rosenbrocks_valley_is_followed_to_its_end():
    strategy = pattern_search(population_size=4, expansion=2.0)
    state, _ = _maximise(strategy, jnp.array([-1.2, 1.0]), _rosenbrock, 20_000)
    # By scipy's own function; the way along the valley is long for polls along the axes.
    assert rosen(np.asarray(state.centre, np.float64)) < 1e-4
    np.testing.assert_allclose(state.centre, 1.0, atol=0.02)


def test_the_hybrid_polishes_what_the_genetic_algorithm_found():
    target = jnp.linspace(-1.0, 1.0, 12)
    strategy = hybrid_ga(population_size=100, lower=-2.0, upper=2.0, breeding_generations=30)
    state, metrics = _maximise(strategy, jnp.zeros(12), lambda x: jnp.sum((x - target) ** 2), 200)
    best = np.asarray(metrics.fitness.best_fitness)
    # With the thesis' rates next to nothing is new after generation 0.
    assert -5 < best[29] < -0.05
    assert float(state.searching.best_fitness) > -1e-5
    np.testing.assert_array_equal(metrics.mesh[:30], 1.0)
    # The search starts at the best of the last generation that was bred.
    assert best[30] >= best[29]
    np.testing.assert_array_equal(best[:30], np.maximum.accumulate(best[:30]))


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("expansion", 0.9, "expansion must be .* got 0.9"),
        ("contraction", 1.0, "contraction must be .* got 1.0"),
        ("initial_mesh", 0.0, "initial_mesh must be .* got 0.0"),
        ("smallest_mesh", 0.0, "smallest_mesh must be .* got 0.0"),
        ("scale", -1.0, "scale must be .* got -1.0"),
    ],
)
def test_a_wrong_setting_is_named(name: str, value: float, message: str):
    with pytest.raises(ValueError, match=message):
        pattern_search(population_size=4, **{name: value})  # type: ignore[arg-type]


def test_the_hybrid_needs_a_generation_to_breed():
    with pytest.raises(ValueError, match="breeding_generations must be .* got 0"):
        hybrid_ga(population_size=4, lower=0.0, upper=1.0, breeding_generations=0)
