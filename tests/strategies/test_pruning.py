"""Tests for evolutions that prune, told a fitness chosen by hand."""

import functools
import pickle
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.strategies import has_declined, self_adaptive_ga, with_pruning
from mjxwalk.strategies import links as algebra

POPULATION_SIZE = 12
NUM_ELITES = 2
# Links 0 to 7 have a weight in each set; what is left in either and the gene stay for good.
NUMBERS = {"first": np.array([-1, *range(8)]), "second": np.array([*range(8), -1]), "gene": -1}
TEMPLATE = {"first": jnp.ones(9), "second": jnp.ones(9), "gene": jnp.ones(())}
PROTECTED = {"first": 0, "second": 8}

_ga = functools.partial(
    self_adaptive_ga,
    population_size=POPULATION_SIZE,
    sigma=0.1,
    initial_sigma=0.1,
    num_elites=NUM_ELITES,
    links=NUMBERS,
)


def strategy(**settings: Any) -> Any:
    chosen = {"every": 3, "reference": 5, "window": 3, "settle": 4} | settings
    return with_pruning(_ga(), links=NUMBERS, num_elites=NUM_ELITES, **chosen)


@pytest.fixture(scope="module")
def ask() -> Any:
    return jax.jit(strategy().ask)


@pytest.fixture(scope="module")
def tell() -> Any:
    return jax.jit(strategy().tell)


@functools.cache
def unpruned() -> Any:
    return jax.jit(_ga().init)(jax.random.key(0), TEMPLATE)


def begun(elites: list[float]) -> Any:
    return strategy().begin(unpruned(), np.array(elites, np.float32))


def fitness_with(elite: float) -> Any:
    # The last is the best, so that the elite, which stands in front and loses no link, dies out.
    return elite - jnp.arange(float(POPULATION_SIZE))[::-1]


def evolve(ask: Any, tell: Any, state: Any, elites: list[float], *, first: int = 0) -> list[Any]:
    """Returns population, asked state, told state and metrics of generations with such elites."""
    generations: list[Any] = []
    for index, elite in enumerate(elites, first):
        key_ask, key_tell = jax.random.split(jax.random.key(100 + index))
        population, asked = ask(key_ask, state)
        state, metrics = tell(key_tell, population, fitness_with(elite), asked)
        generations.append((population, asked, state, metrics))
    return generations


def num_links(state: Any) -> np.ndarray[Any, Any]:
    numbers = jax.tree.map(
        lambda number, leaf: jnp.broadcast_to(jnp.asarray(number), leaf.shape), NUMBERS, TEMPLATE
    )
    return np.asarray(jax.vmap(algebra.count_links, in_axes=(0, None))(state.inner.mask, numbers))


@pytest.mark.parametrize(
    ("recent", "declined"),
    [([8.0, 9.0, 100.0], False), ([8.9, 8.9, 100.0], True), ([0.0, 9.0, 9.0], False)],
)
def test_a_median_below_nine_tenths_of_the_references_is_a_decline(
    recent: list[float], declined: bool
):
    reference = jnp.array([1.0, 10.0, 10.0, 10.0, 99.0])
    # 9 itself is not below; in float32 0.9 x 10 is 9.
    assert bool(has_declined(jnp.array(recent), reference, 0.9)) is declined


def test_every_third_generation_from_the_first_all_but_the_elite_lose_a_link(ask: Any, tell: Any):
    generations = evolve(ask, tell, begun([10.0] * 5), [10.0] * 7)
    lost = [int(asked.num_pruned) for _, asked, _, _ in generations]
    assert lost == [10, 0, 0, 10, 0, 0, 10]
    assert [int(metrics.num_pruned) for *_, metrics in generations] == lost
    first = num_links(generations[0][1])
    np.testing.assert_array_equal(first, [8, 8] + [7] * 10)
    assert float(generations[0][3].mean_num_links) == pytest.approx((16 + 70) / 12)


def test_the_elite_is_asked_again_to_the_bit(ask: Any, tell: Any):
    *_, (_, _, told, _) = evolve(ask, tell, begun([10.0] * 5), [10.0] * 3)
    population, asked = ask(jax.random.key(9), told)
    assert int(asked.num_pruned) > 0
    for before, after in zip(
        jax.tree.leaves((told.inner.population, told.inner.mask)),
        jax.tree.leaves((population, asked.inner.mask)),
        strict=True,
    ):
        kept = np.asarray(before)[:NUM_ELITES].tobytes()
        assert np.asarray(after)[:NUM_ELITES].tobytes() == kept


def test_protected_weights_never_go_and_both_weights_of_a_link_go_together():
    busy = strategy(every=1)
    state = busy.begin(unpruned(), np.full(5, 10.0, np.float32))
    generations = evolve(jax.jit(busy.ask), jax.jit(busy.tell), state, [10.0] * 25)
    for population, asked, _, _ in generations:
        for leaf, place in PROTECTED.items():
            assert np.all(asked.inner.mask[leaf][:, place])
            assert np.all(population[leaf][:, place] != 0)
        assert np.all(asked.inner.mask["gene"])
        first, second = (np.asarray(asked.inner.mask[leaf]) for leaf in ("first", "second"))
        np.testing.assert_array_equal(first[:, 1:], second[:, :8])
        np.testing.assert_array_equal(np.asarray(population["first"]) != 0, first)
    assert num_links(generations[-1][1]).mean() < 4


def test_a_removed_link_comes_back_only_from_a_parent_that_has_it(ask: Any, tell: Any):
    generations = evolve(ask, tell, begun([10.0] * 5), [10.0] * 12)
    came_back = 0
    for (_, asked, told, _), (_, following, _, _) in zip(
        generations, generations[1:], strict=False
    ):
        # The last of them are the best fifth.
        parents = np.asarray(asked.inner.mask["first"])[-2:]
        children = np.asarray(told.inner.mask["first"])
        assert not np.any(children & ~parents.any(axis=0))
        assert not np.any(np.asarray(following.inner.mask["first"]) & ~children)
        came_back += int(np.sum(children & ~parents.all(axis=0)))
    assert came_back > 0


def test_removing_stops_with_the_decline_and_the_strategy_is_finished_later(ask: Any, tell: Any):
    # Reference median 10. Medians of the last three: 10, 10, 9.5, 8.9 (declined), and so on.
    elites = [9.5, 12.0, 8.9, 8.9, 20.0, 20.0, 20.0, 20.0]
    state = begun([1.0, 10.0, 10.0, 10.0, 99.0])
    generations = evolve(ask, tell, state, elites)
    stopped = [int(told.stopped_at) for _, _, told, _ in generations]
    assert stopped == [-1, -1, -1, 4, 4, 4, 4, 4]
    finished = [bool(told.finished) for _, _, told, _ in generations]
    assert finished == [False] * 7 + [True]
    lost = [int(metrics.num_pruned) > 0 for *_, metrics in generations]
    assert lost == [True, False, False, True, False, False, False, False]


def test_without_a_reference_it_is_gathered_first(ask: Any, tell: Any):
    state = jax.jit(strategy().init)(jax.random.key(0), TEMPLATE)
    generations = evolve(ask, tell, state, [6.0, 7.0, np.nan, 8.0, 9.0, 50.0, 50.0])
    assert [int(told.age) for _, _, told, _ in generations] == [-4, -3, -2, -1, 0, 1, 2]
    assert [int(metrics.num_pruned) for *_, metrics in generations] == [0, 0, 0, 0, 0, 10, 0]
    last = generations[-1][2]
    np.testing.assert_array_equal(last.reference, [6.0, 7.0, -np.inf, 8.0, 9.0])
    np.testing.assert_array_equal(last.recent, [9.0, 50.0, 50.0])


def test_a_reference_too_short_is_completed_and_of_a_longer_one_the_end_counts():
    assert int(begun([1.0, 2.0]).age) == -3
    longer = begun([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    assert int(longer.age) == 0
    np.testing.assert_array_equal(longer.reference, [2.0, 3.0, 4.0, 5.0, 6.0])
    np.testing.assert_array_equal(longer.recent, [4.0, 5.0, 6.0])


def test_between_removals_it_is_the_strategy_itself(ask: Any, tell: Any):
    state = begun([10.0] * 5)._replace(age=jnp.array(1, jnp.int32))
    [(population, _, told, metrics)] = evolve(ask, tell, state, [10.0])
    _, key_tell = jax.random.split(jax.random.key(100))
    plain, plain_metrics = jax.jit(_ga().tell)(
        key_tell, population, fitness_with(10.0), state.inner
    )
    for a, b in zip(jax.tree.leaves(told.inner), jax.tree.leaves(plain), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-6)  # rounds as another program does
    assert metrics[:2] == plain_metrics


def test_resuming_from_a_saved_state_gives_the_same_bits(ask: Any, tell: Any):
    # Removing stops in the fourth generation, so that the states saved are before and after that.
    elites = [9.5, 12.0, 8.9, 8.9, 20.0, 20.0]
    start = begun([10.0] * 5)
    whole = evolve(ask, tell, start, elites)
    for halfway in (1, 5):
        saved = pickle.dumps(jax.tree.map(np.asarray, whole[halfway - 1][2]))
        state = jax.tree.map(jnp.asarray, pickle.loads(saved))
        resumed = evolve(ask, tell, state, elites[halfway:], first=halfway)
        for a, b in zip(jax.tree.leaves(resumed[-1]), jax.tree.leaves(whole[-1]), strict=True):
            assert np.asarray(a).tobytes() == np.asarray(b).tobytes()


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ({"every": 0}, "every must be a whole number >= 1, got 0"),
        ({"window": 6}, r"window must be a whole number in \[1, 5\], got 6"),
        ({"reference": 0}, "reference must be a whole number >= 1, got 0"),
        ({"settle": -1}, "settle must be a whole number >= 0, got -1"),
        ({"floor": -0.1}, "floor must be finite and >= 0.0, got -0.1"),
    ],
)
def test_a_wrong_setting_is_refused_with_its_range(setting: dict[str, Any], sentence: str):
    with pytest.raises(ValueError, match=sentence):
        strategy(**setting)


def test_what_does_not_fit_is_refused_in_one_sentence():
    with pytest.raises(ValueError, match="links must hold whole numbers alone, got 0.5"):
        with_pruning(_ga(), links=0.5)
    with pytest.raises(ValueError, match="links must be one value or a pytree prefix"):
        with_pruning(_ga(), links={"first": 1}).init(jax.random.key(0), TEMPLATE)
