"""Tests of what ranks are worth, by hand."""

import jax.numpy as jnp
import numpy as np

from mjxwalk.strategies import ranks

NAN, INF = np.nan, np.inf


def test_centred_ranks_run_from_half_to_minus_half_and_nan_is_lowest():
    got = ranks.centred_ranks(jnp.array([3.0, NAN, INF, -INF, 5.0]))
    np.testing.assert_allclose(got, [0.0, -0.5, 0.5, -0.25, 0.25])


def test_equal_fitness_is_worth_the_same():
    got = ranks.centred_ranks(jnp.array([1.0, 2.0, 1.0, NAN, NAN]))
    np.testing.assert_allclose(got, [0.125, 0.5, 0.125, -0.375, -0.375])


def test_a_generation_of_one_value_is_worth_nothing():
    for value in (0.0, NAN, INF, -INF):
        for worth in (ranks.centred_ranks, ranks.nes_utilities):
            np.testing.assert_allclose(worth(jnp.full(7, value)), np.zeros(7), atol=1e-7)


def test_nes_utilities_are_those_of_the_papers_formula():
    # Four genotypes: ln 3 - ln k for k = 1, 2, and nothing for 3, 4.
    raw = np.array([np.log(3.0), np.log(1.5), 0.0, 0.0])
    expected = raw / raw.sum() - 0.25
    got = ranks.nes_utilities(jnp.array([0.0, 2.0, -1.0, 1.0]))
    np.testing.assert_allclose(got, expected[[2, 0, 3, 1]], rtol=1e-6)


def test_fitness_by_size_takes_infinity_for_the_highest_and_nan_for_the_lowest():
    got = ranks.finite(jnp.array([1.0, NAN, INF, -INF, 5.0]))
    np.testing.assert_array_equal(got, [1.0, 1.0, 5.0, 1.0, 5.0])
    np.testing.assert_array_equal(ranks.finite(jnp.array([NAN, INF])), [0.0, 0.0])
