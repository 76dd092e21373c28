"""Tests of trials as a table, and of what one walker is given of it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs import (
    TRIAL_AXES,
    Flame,
    LeggedEnv,
    Planar7,
    Reil,
    Trial,
    Trials,
    TrialState,
)

PLAIN = Trials(np.arange(6.0).reshape(3, 2))
DRAWN = PLAIN._replace(start=np.arange(12.0).reshape(3, 4), load=np.array([0.1, 0.2, 0.3]))


def test_some_of_the_trials_are_trials() -> None:
    assert PLAIN.num == DRAWN.num == 3
    later = DRAWN.take(slice(1, None))
    assert later.num == 2
    np.testing.assert_array_equal(later.heights, [[2.0, 3.0], [4.0, 5.0]])
    np.testing.assert_array_equal(later.start, [[4.0, 5.0, 6.0, 7.0], [8.0, 9.0, 10.0, 11.0]])
    np.testing.assert_array_equal(later.load, [0.2, 0.3])
    again = DRAWN.take(np.array([2, 0, 2]))
    np.testing.assert_array_equal(again.load, [0.3, 0.1, 0.3])
    assert PLAIN.take(slice(2)).start is None and PLAIN.take(slice(2)).load is None


def test_a_walker_is_given_its_row_on_the_ground_that_all_share() -> None:
    given = DRAWN.given(2)
    assert given.ground.heights is DRAWN.heights and given.ground.row == 2
    np.testing.assert_array_equal(given.start, [8.0, 9.0, 10.0, 11.0])
    assert given.load == 0.3
    plain = PLAIN.given(1)
    assert plain.start is None and plain.load is None


def test_several_walkers_are_mapped_over_their_trials_and_not_over_the_ground() -> None:
    rows = np.array([1, 1, 0, 2], np.int32)

    def told(given: Trial) -> jax.Array:
        assert given.ground.heights.shape == (3, 2) and given.start is not None
        height = given.ground.heights[given.ground.row, 0]
        return jnp.stack([height, given.start[0], jnp.asarray(given.load)])

    found = jax.vmap(told, (TRIAL_AXES,))(jax.tree.map(jnp.asarray, DRAWN.given(rows)))
    expected = [[2.0, 4.0, 0.2], [2.0, 4.0, 0.2], [0.0, 0.0, 0.1], [4.0, 8.0, 0.3]]
    np.testing.assert_allclose(found, expected, rtol=1e-6)


@pytest.mark.parametrize("env", [Planar7(), Flame(), Reil()], ids=["planar", "spatial", "hips"])
def test_level_trials_are_as_the_sampled_ones_but_flat_and_usual(env: LeggedEnv) -> None:
    level, sampled = env.level_trials(3), env.sample_trials(jax.random.key(0), 3)
    assert level.num == sampled.num == 3
    assert level.heights.shape == sampled.heights.shape and not level.heights.any()
    assert level.start is None and level.load is None


def test_a_trial_begins_with_nothing_counted() -> None:
    begun = TrialState.begin()
    assert not any(bool(leaf) for leaf in begun)
    assert begun.num_steps.dtype == jnp.int32 and begun.done.dtype == bool
