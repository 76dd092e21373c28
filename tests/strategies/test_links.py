"""Tests for the removal of links, on genotypes small enough to count by hand."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from mjxwalk.strategies import links
from mjxwalk.strategies.operators import Individual
from mjxwalk.strategies.prefixes import check_links, match_links

# As a walker's: two sets of weights share links 0 to 3, and the first and the gene stay for good.
NUMBERS = {
    "initiation": jnp.array([-1, 0, 1, 2, 3]),
    "walking": jnp.array([-1, 0, 1, 2, 3]),
    "blend": jnp.array(-1),
}
GENOTYPE = {
    "initiation": jnp.array([1.0, 2.0, 3.0, 4.0, 5.0]),
    "walking": jnp.array([6.0, 7.0, 8.0, 9.0, 10.0]),
    "blend": jnp.array(11.0),
}


remove_random_link = jax.jit(links.remove_random_link)
prune_population = jax.jit(links.prune_population)


def individual(present: list[int]) -> Individual:
    row = jnp.array([True, *(number in present for number in range(4))])
    mask = {"initiation": row, "walking": row, "blend": jnp.array(True)}
    return Individual(jax.tree.map(lambda w, m: jnp.where(m, w, 0.0), GENOTYPE, mask), mask)


def present(mask: Any) -> np.ndarray[Any, Any]:
    return np.asarray(links.present_links(mask, NUMBERS))


def same(one: Any, other: Any) -> bool:
    leaves = zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True)
    return all(np.array_equal(a, b) for a, b in leaves)


def test_all_weights_of_the_removed_link_and_no_others_go():
    before = individual([0, 2, 3])
    after = remove_random_link(jax.random.key(0), before, NUMBERS)
    gone = np.flatnonzero(present(before.mask) & ~present(after.mask))
    assert gone.size == 1
    expected = individual([number for number in (0, 2, 3) if number != gone[0]])
    assert same(after, expected)


def test_each_link_that_is_there_is_as_likely_to_go():
    # Link 1 has two more weights and link 3 has lost one of its two, which must not count.
    numbers = {**NUMBERS, "more": jnp.array([1, 1])}
    start = individual([0, 1, 3])
    mask = {**start.mask, "more": jnp.ones(2, bool)}
    mask["walking"] = mask["walking"].at[4].set(False)
    start = Individual({**GENOTYPE, "more": jnp.ones(2)}, mask)
    keys = jax.random.split(jax.random.key(1), 6_000)
    remove = jax.jit(jax.vmap(links.remove_random_link, in_axes=(0, None, None)))
    after = jax.vmap(links.present_links, in_axes=(0, None))(
        remove(keys, start, numbers).mask, numbers
    )
    counts = 6_000 - np.asarray(after)[:, [0, 1, 3]].sum(axis=0)
    assert counts.sum() == 6_000
    # By chance alone the counts are as uneven as that once in a thousand keys.
    assert stats.chisquare(counts).pvalue > 1e-3


def test_an_individual_is_stripped_of_all_but_what_is_protected_and_then_left_alone():
    everyone = individual([0, 1, 2, 3])
    for number_left in (3, 2, 1, 0, 0, 0):
        key = jax.random.key(number_left)
        everyone = remove_random_link(key, everyone, NUMBERS)
        assert int(links.count_links(everyone.mask, NUMBERS)) == number_left
    assert same(everyone, individual([]))
    assert everyone.genotype["blend"] == 11.0 and everyone.genotype["walking"][0] == 6.0


def test_where_all_is_protected_nothing_goes():
    protected = jax.tree.map(lambda leaf: jnp.full(leaf.shape, -1), GENOTYPE)
    start = individual([0, 1])
    assert same(links.remove_random_link(jax.random.key(0), start, protected), start)


def test_a_population_loses_a_link_each_but_who_is_kept_loses_none_to_the_bit():
    everyone = jax.tree.map(
        lambda *leaves: jnp.stack(leaves), *[individual([0, 1, 2, 3]) for _ in range(40)]
    )
    everyone.genotype["blend"] = everyone.genotype["blend"].at[7].set(-0.0)
    keep = jnp.arange(40) % 7 == 0
    after = prune_population(jax.random.key(0), everyone, NUMBERS, keep)
    counts = jax.vmap(links.count_links, in_axes=(0, None))(after.mask, NUMBERS)
    np.testing.assert_array_equal(counts, np.where(keep, 4, 3))
    for a, b in zip(jax.tree.leaves(after), jax.tree.leaves(everyone), strict=True):
        assert np.asarray(a)[keep].tobytes() == np.asarray(b)[keep].tobytes()
    # Each with its own draw: 34 of the same would be one in 4^33.
    assert np.unique(np.asarray(after.mask["walking"])[~keep], axis=0).shape[0] == 4


def test_survival_counts_runs_and_the_reduction_keeps_what_enough_of_them_kept():
    masks = {
        "a": jnp.array([[1, 1, 0, 1], [1, 1, 0, 0], [1, 1, 0, 1], [1, 1, 1, 1], [1, 0, 0, 0]], bool)
    }
    counts = links.survival(masks)
    np.testing.assert_array_equal(counts["a"], [5, 4, 1, 3])
    for threshold, kept in ((0.8, [1, 1, 0, 0]), (0.81, [1, 0, 0, 0]), (0.6, [1, 1, 0, 1])):
        mask = links.reduce_links(counts, 5, threshold=threshold)
        np.testing.assert_array_equal(mask["a"], np.array(kept, bool))


def test_forty_of_fifty_runs_are_enough_as_in_the_paper():
    mask = links.reduce_links(jnp.array([39, 40, 41]), 50)
    np.testing.assert_array_equal(mask, [False, True, True])


@pytest.mark.parametrize(
    ("threshold", "num_runs", "fewest"), [(0.55, 20, 11), (0.07, 100, 7), (0.8, 6, 5), (0.0, 3, 0)]
)
def test_a_share_of_the_runs_that_is_a_whole_number_is_not_rounded_up(
    threshold: float, num_runs: int, fewest: int
):
    # In floating point 0.55 * 20 is above 11 and 0.07 * 100 above 7.
    mask = links.reduce_links(jnp.arange(num_runs + 1), num_runs, threshold=threshold)
    assert int(np.argmax(mask)) == fewest


def test_numbers_are_spread_over_the_template_and_lose_their_gaps():
    matched = match_links(
        {"initiation": np.array([-5, 7, 7, 90, 3]), "walking": 90, "blend": -1}, GENOTYPE
    )
    np.testing.assert_array_equal(matched["initiation"], [-1, 1, 1, 2, 0])
    np.testing.assert_array_equal(matched["walking"], [2, 2, 2, 2, 2])
    assert matched["blend"] == -1


@pytest.mark.parametrize("wrong", [0.0, True, {"a": 1, "b": "x"}, {}])
def test_links_that_are_no_whole_numbers_are_refused(wrong: Any):
    with pytest.raises(ValueError, match="links must hold whole numbers alone, got"):
        check_links(wrong)
