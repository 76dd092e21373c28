"""Tests of statistics of observations, against numpy, and of ARS V2."""

import jax
import jax.numpy as jnp
import numpy as np

from mjxwalk.strategies import ars, observations, with_observations

SEEN = np.random.default_rng(0).normal(3.0, [0.5, 2.0, 0.0], (40, 3)).astype(np.float32)


def _statistics(rows: np.ndarray) -> observations.Statistics:
    def step(
        statistics: observations.Statistics, row: jax.Array
    ) -> tuple[observations.Statistics, None]:
        return observations.add(statistics, row), None

    return jax.jit(lambda seen: jax.lax.scan(step, observations.nothing(3), seen)[0])(rows)


def test_statistics_one_by_one_and_of_parts_are_those_of_all():
    alone = _statistics(SEEN)
    parts = jax.tree.map(
        lambda *leaves: jnp.stack(leaves), _statistics(SEEN[:30]), _statistics(SEEN[30:])
    )
    for got in (alone, jax.jit(observations.merge_all)(parts)):
        assert int(got.num) == 40
        np.testing.assert_allclose(got.mean, SEEN.mean(axis=0), rtol=1e-5)
        np.testing.assert_allclose(got.squares / 40, SEEN.var(axis=0), rtol=1e-4, atol=1e-6)


def test_a_policy_with_statistics_folded_in_does_the_same_with_raw_observations():
    statistics = _statistics(SEEN)
    weights = jnp.array([[1.0, -2.0, 0.5], [0.3, 0.0, 1.0]])
    white = observations.whiten(statistics, jnp.asarray(SEEN[0]))
    # A number that never changes is only centred.
    expected = (SEEN[0] - SEEN.mean(axis=0)) / np.where(
        SEEN.std(axis=0) > 1e-3, SEEN.std(axis=0), 1
    )
    np.testing.assert_allclose(white, expected, rtol=1e-3, atol=1e-5)
    raw, bias = observations.fold_in(statistics, weights)
    np.testing.assert_allclose(raw @ SEEN[0] + bias, weights @ white, rtol=1e-4, atol=1e-4)


def test_before_anything_is_seen_observations_stay_as_they_are():
    white = observations.whiten(observations.nothing(3), jnp.asarray(SEEN[0]))
    np.testing.assert_array_equal(white, SEEN[0])


def test_v2_tells_the_strategy_the_fitness_and_keeps_what_was_observed():
    plain = ars(population_size=4, sigma=0.5)
    strategy = with_observations(plain, num_observed=3)
    state = strategy.init(jax.random.key(0), jnp.zeros((2, 3)))
    tell = jax.jit(strategy.tell_observed)
    for rows in (SEEN[:30], SEEN[30:]):
        population, state = strategy.ask(jax.random.key(1), state)
        before = state.inner
        state, _ = tell(jax.random.key(2), population, jnp.arange(4.0), _statistics(rows), state)
        expected, _ = jax.jit(plain.tell)(jax.random.key(2), population, jnp.arange(4.0), before)
        np.testing.assert_allclose(state.inner.mean, expected.mean, rtol=1e-6)
    np.testing.assert_allclose(state.statistics.mean, SEEN.mean(axis=0), rtol=1e-5)
