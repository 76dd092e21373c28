"""Tests for the summary of a generation's fitness."""

import jax.numpy as jnp
import numpy as np

from mjxwalk.strategies import summarise_fitness


def test_summary_is_over_finite_values_alone():
    fitness = np.array([1.0, np.nan, 4.0, -np.inf, 1.0, np.inf, np.nan], np.float32)
    summary = summarise_fitness(jnp.asarray(fitness))
    np.testing.assert_allclose(summary, [4.0, 2.0, 1.0, 2])


def test_summary_of_nothing_finite_is_nan():
    summary = summarise_fitness(jnp.array([np.nan, np.inf]))
    np.testing.assert_array_equal(summary, [np.nan, np.nan, np.nan, 1])
