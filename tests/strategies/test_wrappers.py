"""Tests of bounds, schedules, masks, islands and repeated trials around any strategy."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import strategies
from mjxwalk.strategies import bounds, islands

TEMPLATE = {"a": jnp.zeros((2, 2)), "b": jnp.ones(3)}


def _jitted(strategy: Any) -> Any:
    # Function by function, as one operation at a time compiles for longer.
    jitted = {name: jax.jit(getattr(strategy, name)) for name in ("init", "ask", "tell")}
    return dataclasses.replace(strategy, **jitted)


def _snes() -> Any:
    return strategies.snes(population_size=8, sigma=1.0)


def test_reflection_folds_back_as_often_as_it_takes():
    got = bounds.reflect(jnp.array([-0.25, 0.25, 1.25, 2.25, -7.75]), jnp.zeros(5), jnp.ones(5))
    np.testing.assert_allclose(got, [0.25, 0.25, 0.75, 0.25, 0.25])


@pytest.mark.parametrize("how", ["clip", "reflect"])
def test_no_genotype_leaves_its_bounds(how: Any):
    upper = {"a": 0.5, "b": jnp.array([0.1, 0.2, 0.3])}
    bounded = _jitted(strategies.with_bounds(_snes(), lower=-0.5, upper=upper, how=how))
    population, _ = bounded.ask(jax.random.key(1), bounded.init(jax.random.key(0), TEMPLATE))
    assert jnp.all(population["b"] <= upper["b"]) and jnp.all(population["a"] <= 0.5)
    assert min(jnp.min(leaf) for leaf in population.values()) >= -0.5
    assert jnp.std(population["a"]) > 0.1


@pytest.mark.usefixtures("unchecked_types")
def test_bounds_that_leave_nothing_are_refused():
    with pytest.raises(ValueError, match=r"upper must be above lower \(1.0\), got 1.0"):
        strategies.with_bounds(_snes(), lower=1.0, upper=1.0)
    with pytest.raises(ValueError, match="how must be clip or reflect, got 'wrap'"):
        strategies.with_bounds(_snes(), lower=0.0, upper=1.0, how="wrap")  # pyright: ignore


def test_a_schedule_gives_each_generation_its_own_value():
    strategy = strategies.with_schedule(
        lambda sigma: strategies.openai_es(population_size=4, sigma=sigma),
        lambda generation: 0.5 ** (1.0 + generation),
    )
    strategy = _jitted(strategy)
    state = strategy.init(jax.random.key(0), TEMPLATE)
    sigmas: list[float] = []
    for generation in range(3):
        population, state = strategy.ask(jax.random.key(1), state)
        state, metrics = strategy.tell(jax.random.key(2), population, jnp.arange(4.0), state)
        sigmas.append(float(metrics.sigma))
        assert int(state.generation) == generation + 1
    np.testing.assert_allclose(sigmas, [0.5, 0.25, 0.125])


def test_masked_weights_are_zero_and_no_dimension():
    mask = {"a": np.array([[True, False], [False, True]]), "b": False}
    strategy = strategies.make("snes", population_size=8, sigma=1.0, mask=mask, groups=None)
    strategy = _jitted(strategy)
    state = strategy.init(jax.random.key(0), TEMPLATE)
    assert state.inner.mean.shape == (2,)
    population, state = strategy.ask(jax.random.key(1), state)
    assert jnp.all(population["b"] == 0) and jnp.all(population["a"][:, 0, 1] == 0)
    assert jnp.all(population["a"][:, 1, 1] != 0)
    new, _ = strategy.tell(jax.random.key(2), population, jnp.arange(8.0), state)
    best_four = np.asarray(population["a"][4:, 0, 0])
    assert np.sign(new.inner.mean[0]) == np.sign(best_four @ [1, 2, 3, 4])


def test_a_mask_that_leaves_nothing_is_refused():
    with pytest.raises(ValueError, match="mask must leave at least one weight"):
        strategies.with_mask(_snes(), False).init(jax.random.key(0), TEMPLATE)


def test_the_best_of_an_island_take_the_places_of_the_worst_of_the_next():
    genotypes = {"w": jnp.arange(8.0).reshape(2, 4)}
    fitness = jnp.array([[1.0, 9.0, jnp.nan, 3.0], [5.0, 2.0, 7.0, 8.0]])
    moved, got = islands.migrate(genotypes, fitness, 1)
    np.testing.assert_array_equal(moved["w"], [[0, 1, 7, 3], [4, 1, 6, 7]])
    np.testing.assert_array_equal(got, [[1, 9, 8, 3], [5, 9, 7, 8]])


def test_islands_that_never_meet_are_as_many_separate_runs():
    strategy = strategies.with_islands(_snes(), num_islands=2, every=1, num_migrants=0)
    assert strategy.population_size == 16
    strategy = _jitted(strategy)
    state = strategy.init(jax.random.key(0), TEMPLATE)
    population, state = strategy.ask(jax.random.key(1), state)
    fitness = jnp.arange(16.0)
    state, _ = strategy.tell(jax.random.key(2), population, fitness, state)
    alone = _jitted(_snes())
    second = jax.tree.map(lambda leaf: leaf[8:], population)
    expected, _ = alone.tell(
        jax.random.key(9), second, fitness[8:], alone.init(jax.random.key(0), TEMPLATE)
    )
    np.testing.assert_allclose(state.inner.mean[1], expected.mean, rtol=1e-6)


def test_common_random_numbers_give_equal_genotypes_equal_fitness():
    def trial(key: Any, genotype: Any) -> Any:
        return genotype + jax.random.normal(key)

    twins = jnp.array([1.0, 1.0, 2.0])
    key = jax.random.key(0)
    common = jax.jit(strategies.evaluator(trial, num_trials=5))(key, twins)
    own = jax.jit(strategies.evaluator(trial, num_trials=5, common=False))(key, twins)
    assert common[0] == common[1] and own[0] != own[1]
    np.testing.assert_allclose(common[2] - common[0], 1.0, rtol=1e-5)
    luck = np.mean([jax.random.normal(k) for k in jax.random.split(key, 5)])
    np.testing.assert_allclose(common[0], 1.0 + luck, rtol=1e-5)
