"""Tests of networks that lose their weakest links and grow others."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import strategies
from mjxwalk.strategies import rewiring, with_rewiring

# Two layers of 10 and 20 links; each link of the first has two weights, and biases stay.
LINKS = {
    "first": np.stack([np.arange(10)] * 2),
    "second": 10 + np.arange(20),
    "bias": -1,
}
GROUPS = {"first": 0, "second": 1, "bias": 1}
TEMPLATE = {"first": jnp.zeros((2, 10)), "second": jnp.zeros(20), "bias": jnp.zeros(3)}
SIZE = 12


def rewired(strategy: Any, **settings: Any) -> Any:
    chosen: dict[str, Any] = {"every": 2, "fraction": 0.3, "density": 0.5, **settings}
    return with_rewiring(strategy, links=LINKS, groups=GROUPS, **chosen)


def snes() -> Any:
    return strategies.snes(population_size=SIZE, sigma=0.5)


def self_adaptive_ga() -> Any:
    return strategies.self_adaptive_ga(
        population_size=SIZE, sigma=0.1, initial_sigma=0.5, links=LINKS, groups=GROUPS
    )


def evolved(strategy: Any, num: int = 16) -> list[tuple[Any, Any, Any]]:
    """Returns population, state that was asked and metrics of generations."""
    ask, tell = jax.jit(strategy.ask), jax.jit(strategy.tell)
    state = strategy.init(jax.random.key(0), TEMPLATE)
    found: list[tuple[Any, Any, Any]] = []
    for key in jax.random.split(jax.random.key(1), num):
        key_ask, key_tell = jax.random.split(key)
        population, asked = ask(key_ask, state)
        fitness = -jnp.sum((population["second"] - 1.0) ** 2, axis=1)
        state, metrics = tell(key_tell, population, fitness, asked)
        found.append((population, asked, metrics))
    return found


def rewire(strength: Any, present: Any, chance: Any, layer: Any, **settings: float) -> list[int]:
    there = rewiring.rewire_network(
        jnp.asarray(strength), jnp.asarray(present), jnp.asarray(chance), layer, **settings
    )
    return np.flatnonzero(np.asarray(there)).tolist()


def test_the_weakest_go_and_those_with_the_highest_chance_grow() -> None:
    layer = np.array([0] * 10 + [-1] * 2, np.int32)
    strength = np.arange(12.0)[::-1] + 1.0  # the last are the weakest
    present = np.array([True] * 10 + [False] * 2)
    full = {"fraction": 0.3, "density": 0.4}
    # From all ten to seven, far from four: nothing grows.
    assert rewire(strength, present, np.zeros(12), layer, **full) == [0, 1, 2, 3, 4, 5, 6]
    chance = np.array([0.0, 0.0, 0.0, 0.0, 0.1, 0.9, 0.2, 0.3, 0.3, 0.8, 1.0, 1.0])
    # Of four one goes, and one grows in its place.
    few = np.array([True] * 4 + [False] * 8)
    assert rewire(strength, few, chance, layer, **full) == [0, 1, 2, 5]


def test_layers_lose_each_their_own_weakest() -> None:
    layer = np.array([0] * 4 + [1] * 4, np.int32)
    strength = np.array([1.0, 2.0, 3.0, 4.0, 0.01, 0.02, 0.03, 0.04])
    found = rewire(strength, np.ones(8, bool), np.zeros(8), layer, fraction=0.5, density=0.5)
    assert found == [2, 3, 6, 7]


def test_no_layer_loses_all_links() -> None:
    layer = np.zeros(3, np.int32)
    one = np.array([False, True, False])
    found = rewire(np.zeros(3), one, np.array([0.1, 0.2, 0.3]), layer, fraction=1.0, density=0.01)
    assert found == [2]


@pytest.mark.parametrize("make", [snes, self_adaptive_ga])
def test_links_are_fewer_each_time_down_to_the_density_and_change_places_then(make: Any) -> None:
    found = evolved(rewired(make()))
    # 10, 7, 5 and 20, 14, 10; half of each is 5 and 10.
    if make is snes:
        counts = [int(metrics.mean_num_links) for *_, metrics in found]
        assert counts[:7] == [30, 30, 21, 21, 15, 15, 15]
        assert counts[-1] == 15
        masks = [np.asarray(asked.inner.mask["second"][0]) for _, asked, _ in found]
        assert masks[-1].sum() == masks[-3].sum() == 10
        assert not np.array_equal(masks[-1], masks[-3])
    else:  # individuals recombine their networks, of which some then have more links, some fewer
        assert float(found[-1][2].mean_num_links) == pytest.approx(15, abs=3)
    for population, asked, _ in found:
        mask = asked.inner.mask
        np.testing.assert_array_equal(mask["first"][:, 0], mask["first"][:, 1])
        assert np.all(mask["bias"])
        for name, leaf in population.items():
            assert not np.any(np.asarray(leaf)[~np.asarray(mask[name])])


def test_the_links_of_the_population_mean_that_are_nearest_to_zero_go() -> None:
    (population, asked, _), (_, after, _) = evolved(rewired(snes(), every=1), 2)
    second = np.abs(np.mean(np.asarray(population["second"], np.float64), axis=0))
    first = np.linalg.norm(np.mean(np.asarray(population["first"], np.float64), axis=0), axis=0)
    assert np.all(asked.inner.mask["first"]) and np.all(asked.inner.mask["second"])
    gone = ~np.asarray(after.inner.mask["second"][0])
    assert set(np.flatnonzero(gone)) == set(np.argsort(second)[:6])
    gone = ~np.asarray(after.inner.mask["first"][0, 0])
    assert set(np.flatnonzero(gone)) == set(np.argsort(first)[:3])


@functools.cache
def _sparse_search() -> tuple[Any, Any]:
    # Of five links one goes at a time, so that four can stay.
    settings = {"every": 10, "fraction": 0.2, "density": 0.25}
    strategy = rewired(strategies.snes(population_size=40, sigma=0.3), **settings)
    ask, tell = jax.jit(strategy.ask), jax.jit(strategy.tell)
    state = strategy.init(jax.random.key(0), TEMPLATE)
    for key in jax.random.split(jax.random.key(1), 200):
        key_ask, key_tell = jax.random.split(key)
        population, asked = ask(key_ask, state)
        wanted = jnp.zeros(20).at[np.array([3, 7, 11, 13])].set(2.0)
        fitness = -jnp.sum((population["second"] - wanted) ** 2, axis=1)
        state, _ = tell(key_tell, population, fitness, asked)
    return ask(jax.random.key(2), state)


def test_links_that_matter_are_kept() -> None:
    population, state = _sparse_search()
    there = np.asarray(state.inner.mask["second"][0])
    assert there.sum() == 5 and there[[3, 7, 11, 13]].all()
    np.testing.assert_allclose(np.mean(population["second"], axis=0)[3:8:4], 2.0, atol=0.3)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"every": 0}, "every must be a whole number >= 1"),
        ({"fraction": 0.0}, "fraction must be finite and > 0.0"),
        ({"density": 1.5}, "density must be finite and .* <= 1.0"),
    ],
)
def test_wrong_settings_are_named(settings: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        rewired(snes(), **settings)


def test_links_must_fit_the_template() -> None:
    with pytest.raises(ValueError, match="links"):
        rewired(snes()).init(jax.random.key(0), {"other": jnp.zeros(3)})
