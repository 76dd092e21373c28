"""Tests for pruning around strategies that know no masks."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import strategies
from mjxwalk.strategies import evolving_masks, with_pruning

POPULATION_SIZE = 10
NUM_ELITES = 2
# Both weights of a link go together, and the last weight of either leaf stays for good.
LINKS = {"in": np.array([0, 1, 2, 3, -1]), "out": np.array([0, 1, 2, 3, -1])}
TEMPLATE = {"in": jnp.ones(5), "out": jnp.ones(5)}


def _pruned(strategy: Any) -> Any:
    settings = {"every": 2, "reference": 2, "window": 2, "settle": 2}
    return with_pruning(strategy, links=LINKS, num_elites=NUM_ELITES, **settings)


def _cma() -> Any:
    return strategies.sep_cma_es(population_size=POPULATION_SIZE, sigma=0.3)


@functools.cache
def _evolved() -> list[Any]:
    """Returns population, asked state, told state and metrics of generations of sep-CMA-ES, for
    which links 0 and 1 are good and the others bad."""
    strategy = _pruned(_cma())
    ask, tell = jax.jit(strategy.ask), jax.jit(strategy.tell)
    state = strategy.begin(_cma().init(jax.random.key(0), TEMPLATE), np.full(2, 1.0, np.float32))
    generations: list[Any] = []
    for key in jax.random.split(jax.random.key(1), 12):
        key_ask, key_tell = jax.random.split(key)
        population, asked = ask(key_ask, state)
        there = (population["in"] != 0).astype(float)
        fitness = 100 + there @ jnp.array([10.0, 10.0, -10.0, -10.0, 0.0])
        fitness -= jnp.arange(10.0)[::-1] / 100  # no ties
        state, metrics = tell(key_tell, population, fitness, asked)
        generations.append((population, asked, state, metrics))
    return generations


def test_selection_decides_which_links_a_distribution_loses():
    for population, asked, _, metrics in _evolved():
        np.testing.assert_array_equal(population["in"] != 0, asked.inner.mask["in"])
        np.testing.assert_array_equal(asked.inner.mask["in"], asked.inner.mask["out"])
        assert np.all(asked.inner.mask["in"][:, -1])
        assert metrics.mean_learning_rate is None
    lost = [int(metrics.num_pruned) for *_, metrics in _evolved()]
    assert lost[:4] == [8, 0, 8, 0]
    # Of the generation after the last, which has not lost links yet.
    share = np.mean(_evolved()[-1][2].inner.mask["in"], axis=0)
    np.testing.assert_array_equal(share[:4], [1, 1, 0, 0])


def test_absent_weights_tell_the_strategy_nothing():
    population, asked, told, _ = _evolved()[2]
    drawn = asked.inner.drawn
    assert jnp.any(population["in"] == 0) and jnp.all(drawn["in"] != 0)
    there = (population["in"] != 0).astype(float)
    fitness = (
        100 + there @ jnp.array([10.0, 10.0, -10.0, -10.0, 0.0]) - jnp.arange(10.0)[::-1] / 100
    )
    expected, _ = jax.jit(_cma().tell)(jax.random.key(9), drawn, fitness, asked.inner.inner)
    # Another program rounds otherwise.
    np.testing.assert_allclose(told.inner.inner.mean, expected.mean, rtol=1e-5)


def test_an_elite_of_a_genetic_algorithm_keeps_its_mask():
    strategy = _pruned(
        strategies.deep_ga(
            population_size=POPULATION_SIZE, sigma=0.1, initial_sigma=0.1, num_elites=NUM_ELITES
        )
    )
    ask, tell = jax.jit(strategy.ask), jax.jit(strategy.tell)
    state = strategy.init(jax.random.key(0), TEMPLATE)._replace(age=jnp.zeros((), jnp.int32))
    population, state = ask(jax.random.key(1), state)
    fitness = jnp.arange(10.0)
    state, _ = tell(jax.random.key(2), population, fitness, state)
    following, _ = ask(jax.random.key(3), state)
    for leaf in TEMPLATE:
        assert jnp.any(population[leaf] == 0)
        np.testing.assert_array_equal(following[leaf][:2], population[leaf][np.array([9, 8])])


def test_a_mask_takes_whole_links_from_either_of_two_of_the_best():
    best = {"w": jnp.array([[1, 0, 1, 0], [0, 1, 0, 1], [0, 0, 0, 0]], bool)}
    numbers = np.array([0, 1, 0, 1])
    recombine = jax.jit(
        lambda key: evolving_masks.recombine_masks(key, best, numbers, 2, 1, 200)["w"]
    )
    masks = np.asarray(recombine(jax.random.key(0)))
    np.testing.assert_array_equal(masks[0], best["w"][0])
    np.testing.assert_array_equal(masks[:, :2], masks[:, 2:])
    kinds, counts = np.unique(masks[1:, :2], axis=0, return_counts=True)
    assert len(kinds) == 4
    assert np.all(np.abs(counts - 50) < 25)  # four standard deviations of 199 fair draws of 4


def test_a_state_that_carries_masks_is_left_alone():
    strategy = strategies.self_adaptive_ga(
        population_size=4, sigma=0.1, initial_sigma=0.1, links=LINKS
    )
    state = jax.jit(strategy.init)(jax.random.key(0), TEMPLATE)
    assert isinstance(state, evolving_masks.CarriesMasks)
    assert evolving_masks.carry(_cma(), state) is state


def test_a_controllers_links_serve_every_strategy():
    strategy: Any = strategies.make(
        "snes", population_size=4, sigma=0.1, mask={"in": True, "out": False}, links=LINKS, groups=0
    )
    pruner = _pruned(strategy)
    state = pruner.init(jax.random.key(0), TEMPLATE)
    population, _ = pruner.ask(jax.random.key(1), state)
    assert jnp.all(population["out"] == 0) and jnp.all(population["in"] != 0)
    with pytest.raises(ValueError, match="links must be one value or a pytree prefix"):
        with_pruning(strategy, links={"in": 1}).init(jax.random.key(0), TEMPLATE)
