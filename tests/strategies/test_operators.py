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
    keys = jax.random.split(jax.random.key(0), 12_000)
    first, second = jax.vmap(lambda key: operators.draw_pair(key, 4))(keys)
    pairs = np.zeros((4, 4), int)
    np.add.at(pairs, (np.asarray(first), np.asarray(second)), 1)
    assert pairs.trace() == 0
    # Each of 12 pairs is expected 1,000 times with a standard deviation of 30; five of them.
    np.testing.assert_allclose(pairs[~np.eye(4, dtype=bool)], 1_000, atol=151)


def test_a_single_parent_is_paired_with_itself():
    assert operators.draw_pair(jax.random.key(0), 1) == (0, 0)


def test_normal_numbers_are_standard_and_independent_between_leaves():
    tree = {"a": jnp.zeros((100, 100)), "b": [jnp.zeros(10_000)]}
    noise = operators.normal_like(jax.random.key(0), tree)
    values = np.stack([np.ravel(leaf) for leaf in jax.tree.leaves(noise)])
    # Standard errors over 10,000 draws are 0.01 (mean, covariance) and 0.014 (variance); five.
    np.testing.assert_allclose(values.mean(axis=1), 0, atol=0.05)
    np.testing.assert_allclose(np.cov(values), np.eye(2), atol=0.07)


def test_narrow_weights_get_the_tails_of_wide_ones():
    noise = operators.normal_like(jax.random.key(0), jnp.zeros(20_000, jnp.bfloat16))
    assert noise.dtype == jnp.bfloat16
    # 20,000 normal numbers reach 3.5 but with a chance of 1e-4; bfloat16's own stop before 3.
    assert jnp.max(jnp.abs(noise)) > 3.5


def test_coins_are_fair_and_independent():
    coins = operators.coins_like(jax.random.key(0), [jnp.zeros((50, 101)), jnp.zeros(5_050)])
    values = np.stack([np.ravel(coin) for coin in coins])
    # 5,050 coins a leaf: standard error 0.007; five. Neighbours share a word and must not agree.
    np.testing.assert_allclose(values.mean(axis=1), 0.5, atol=0.035)
    for agree in (values[0] == values[1], values[0, 1:] == values[0, :-1]):
        np.testing.assert_allclose(agree.mean(), 0.5, atol=0.035)


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
    child = operators.discrete_crossover(jax.random.key(0), first, second)
    num_from_first = 0
    for weights, mask, offset in zip(
        jax.tree.leaves(child.genotype),
        jax.tree.leaves(child.mask),
        jax.tree.leaves(second.genotype),
        strict=True,
    ):
        np.testing.assert_array_equal(weights, np.asarray(offset) + np.asarray(mask))
        num_from_first += int(mask.sum())
    # 100 fair coins: 50 with a standard deviation of 5; four of them.
    assert 30 <= num_from_first <= 70


def test_crossover_of_an_individual_with_itself_is_the_individual():
    first, _ = _parents()
    child = operators.discrete_crossover(jax.random.key(1), first, first)
    for got, expected in zip(jax.tree.leaves(child), jax.tree.leaves(first), strict=True):
        np.testing.assert_array_equal(got, expected)


def test_mutation_adds_noise_of_each_weights_own_sigma():
    individual = Individual(jnp.full((2, 5_000), 3.0), jnp.ones((2, 5_000), bool))
    sigma = jnp.array([[0.5], [2.0]]) * jnp.ones((2, 5_000))
    step = operators.gaussian_mutation(jax.random.key(0), individual, sigma).genotype - 3.0
    # 5,000 draws give a standard deviation to 1 %; five of those.
    np.testing.assert_allclose(np.std(step, axis=1), [0.5, 2.0], rtol=0.05)


def test_mutation_never_brings_back_a_removed_link():
    mask = jnp.array([True, False, True, False])
    individual = Individual(jnp.array([1.0, 0.0, 2.0, NAN]), mask)
    mutant = operators.gaussian_mutation(jax.random.key(0), individual, jnp.ones(4))
    np.testing.assert_array_equal(mutant.mask, mask)
    np.testing.assert_array_equal(np.asarray(mutant.genotype)[[1, 3]], 0)
    assert not np.any(np.asarray(mutant.genotype)[[0, 2]] == [1.0, 2.0])


def test_learning_rates_step_log_normally_without_drift():
    rates = jnp.full(20_000, 0.7)
    step = operators.log_normal_step(jax.random.key(0), rates, tau=0.3, minimum=1e-6)
    logs = np.log(np.asarray(step) / 0.7)
    # Standard errors: 0.3 / sqrt(20,000) = 0.002 and 0.0015; five.
    np.testing.assert_allclose(logs.mean(), 0, atol=0.011)
    np.testing.assert_allclose(logs.std(), 0.3, atol=0.008)


def test_learning_rates_stop_at_their_minimum():
    step = operators.log_normal_step(jax.random.key(0), jnp.full(100, 0.1), tau=5.0, minimum=0.1)
    assert jnp.min(step) == np.float32(0.1)


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
