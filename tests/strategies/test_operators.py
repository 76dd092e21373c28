"""Tests for the operators of genetic algorithms, mostly against numpy and cases worked by hand."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.strategies import operators
from mjxwalk.strategies.operators import Individual

NAN, INF = np.nan, np.inf


@pytest.mark.parametrize(
    ("fitness", "order"),
    [
        ([1.0, 3.0, 2.0], [1, 2, 0]),
        ([NAN, -INF, 0.0, INF], [3, 2, 1, 0]),
        ([2.0, NAN, 2.0, NAN, 2.0], [0, 2, 4, 1, 3]),
        ([NAN, NAN, NAN], [0, 1, 2]),
        ([0.0, -0.0, 0.0], [0, 1, 2]),
        ([-NAN, -INF], [1, 0]),
    ],
)
def test_best_first_puts_nan_below_minus_infinity_and_keeps_ties_in_order(
    fitness: list[float], order: list[int]
):
    np.testing.assert_array_equal(operators.best_first(jnp.array(fitness)), order)


def test_best_first_agrees_with_a_stable_numpy_sort():
    fitness = np.random.default_rng(0).integers(0, 20, 300).astype(np.float32)
    expected = np.argsort(-fitness, kind="stable")
    np.testing.assert_array_equal(operators.best_first(jnp.asarray(fitness)), expected)


def test_truncation_selection_keeps_the_best():
    chosen = operators.truncation_selection(jnp.array([1.0, NAN, 5.0, 4.0]), 2)
    np.testing.assert_array_equal(chosen, [2, 3])


def test_pairs_differ_and_all_are_equally_likely():
    draws = jax.random.uniform(jax.random.key(0), (12_000, 2))
    first, second = jax.vmap(lambda pair: operators.pick_pair(pair, 4))(draws)
    pairs = np.zeros((4, 4), int)
    np.add.at(pairs, (np.asarray(first), np.asarray(second)), 1)
    assert pairs.trace() == 0
    # Each of 12 pairs is expected 1,000 times with a standard deviation of 30; five of them.
    np.testing.assert_allclose(pairs[~np.eye(4, dtype=bool)], 1_000, atol=151)


def test_the_largest_draw_is_still_a_parent():
    largest = jnp.full(2, np.nextafter(np.float32(1), np.float32(0)))
    first, second = operators.pick_pair(largest, 1_000_003)
    assert (int(first), int(second)) == (1_000_002, 1_000_001)


def test_a_single_parent_is_paired_with_itself():
    assert operators.pick_pair(jnp.array([0.9, 0.9]), 1) == (0, 0)


def _parents() -> tuple[Individual, Individual]:
    # Weights and masks tell which parent a link is from: first is odd and on, second even and off.
    tree = {"a": jnp.arange(40.0).reshape(8, 5), "b": (jnp.arange(60.0),)}
    first = Individual(
        jax.tree.map(lambda leaf: 2 * leaf + 1, tree),
        jax.tree.map(lambda leaf: jnp.ones(leaf.shape, bool), tree),
    )
    second = Individual(
        jax.tree.map(lambda leaf: 2 * leaf, tree),
        jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, bool), tree),
    )
    return first, second


def test_crossover_takes_each_weight_and_its_mask_from_the_same_parent():
    first, second = _parents()
    take_first = jax.tree.map(lambda leaf: leaf % 3 == 0, first.genotype)
    child = operators.discrete_crossover(take_first, first, second)
    np.testing.assert_array_equal(child.mask["b"][0], take_first["b"][0])
    for weights, mask, offset in zip(
        jax.tree.leaves(child.genotype),
        jax.tree.leaves(child.mask),
        jax.tree.leaves(second.genotype),
        strict=True,
    ):
        np.testing.assert_array_equal(weights, np.asarray(offset) + np.asarray(mask))


def test_mutation_adds_noise_times_each_weights_own_sigma():
    individual = Individual(jnp.full((2, 2), 3.0), jnp.ones((2, 2), bool))
    sigma = jnp.array([[0.5, 0.5], [2.0, 2.0]])
    noise = jnp.array([[1.0, -2.0], [1.0, 0.0]])
    mutant = operators.gaussian_mutation(individual, sigma, noise)
    np.testing.assert_array_equal(mutant.genotype, [[3.5, 2.0], [5.0, 3.0]])


def test_mutation_never_brings_back_a_removed_link():
    mask = jnp.array([True, False, True, False])
    individual = Individual(jnp.array([1.0, 0.0, 2.0, NAN]), mask)
    mutant = operators.gaussian_mutation(individual, jnp.ones(4), jnp.ones(4))
    np.testing.assert_array_equal(mutant.mask, mask)
    np.testing.assert_array_equal(mutant.genotype, [2.0, 0.0, 3.0, 0.0])


def test_learning_rates_step_log_normally():
    step = operators.log_normal_step(
        jnp.array([0.7, 2.0]), jnp.array([0.0, -1.5]), tau=0.3, minimum=1e-6
    )
    np.testing.assert_allclose(step, [0.7, 2.0 * np.exp(-0.45)], rtol=1e-6)  # float32


def test_learning_rates_stop_at_their_minimum():
    step = operators.log_normal_step(jnp.full(2, 0.1), jnp.array([-1.0, 1.0]), tau=5.0, minimum=0.1)
    np.testing.assert_allclose(step, [0.1, 0.1 * np.exp(5)], rtol=1e-6)  # float32


def test_a_learning_rate_scales_its_group_alone():
    groups = {"hip": jnp.array([0, 0]), "knee": jnp.array([[1], [2]])}
    sigma = jax.tree.map(lambda group: jnp.full(group.shape, 0.5), groups)
    scale = operators.scale_by_group(jnp.array([1.0, 2.0, 4.0]), groups, sigma)
    np.testing.assert_array_equal(scale["hip"], [0.5, 0.5])
    np.testing.assert_array_equal(scale["knee"], [[1.0], [2.0]])


def test_one_boolean_chooses_a_whole_tree():
    pick: Any = functools.partial(
        operators.choose, first=(jnp.ones(2), {}), second=(jnp.zeros(2), {})
    )
    np.testing.assert_array_equal(pick(jnp.array(True))[0], [1, 1])
    np.testing.assert_array_equal(pick(jnp.array(False))[0], [0, 0])


def test_mutation_draws_some_weights_anew_between_their_bounds():
    """By hand: the first and third draw are below the rate."""
    draws = jnp.array([[0.05, 0.5, 0.0], [0.5, 0.5, 0.25]])
    lower, upper = jnp.array([-1.0, 0.0, 2.0]), jnp.array([1.0, 1.0, 6.0])
    mutated = operators.uniform_mutation(jnp.full(3, 9.0), lower, upper, 0.1, draws)
    np.testing.assert_allclose(mutated, [0.0, 9.0, 3.0])
