"""Tests of what a gait may hide, on motions that are worked out by hand."""

import jax
import numpy as np
import pytest

from mjxwalk.analysis.faults import corner_speeds, measure_faults
from mjxwalk.envs import Flame
from mjxwalk.envs.bodies.flame_body import EULER, PITCH, ROLL
from mjxwalk.replay import Recording

ENV = Flame()
NUM, SECONDS = 101, 1.0
TIME = np.linspace(0.0, SECONDS, NUM, dtype=np.float32)
SPEED, SIDEWAYS = 2.0, 0.1  # m/s


def gliding(touching: np.ndarray) -> Recording:
    """Returns a walker that glides along leaning, in the pose of its start, and rolls to and fro.

    Args:
      touching: which corners touch the ground, in each frame.
    """
    start = ENV.reset(ENV.level_trials().given(0))
    states = jax.tree.map(lambda leaf: np.repeat(np.asarray(leaf)[None], NUM, axis=0), start)
    states.qpos[:, 0], states.qpos[:, 1] = SPEED * TIME, SIDEWAYS * TIME
    states.qpos[:, PITCH], states.qpos[:, ROLL] = 0.2, np.where(np.arange(NUM) % 2, 0.1, -0.1)
    states.qvel[:] = 0.0
    states.qvel[:, :2] = SPEED, SIDEWAYS
    states = states._replace(touching=touching)
    states = jax.tree.map(lambda leaf: leaf[:, None], states)
    return Recording(TIME[:, None], np.zeros((NUM, 1), bool), states)


def corners(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    return np.concatenate([np.repeat(foot[:, None], 4, axis=1) for foot in (left, right)], axis=1)


def test_who_glides_on_both_soles_slides_twice_as_far_as_it_goes() -> None:
    everywhere = np.ones(NUM, bool)
    (row,) = measure_faults(gliding(corners(everywhere, everywhere)), ENV).to_dict("records")
    assert row["slip"] == pytest.approx(2 * np.hypot(SPEED, SIDEWAYS) / SPEED, rel=1e-4)
    assert row["flight"] == 0.0 and np.isnan(row["brush"])
    assert row["drift"] == pytest.approx(SIDEWAYS / SPEED, rel=1e-4)
    assert row["pitch_rad"] == pytest.approx(0.2) and row["roll_rad"] == pytest.approx(0.1)
    assert not row["fell"]


def test_who_glides_above_the_ground_flies_and_does_not_slide() -> None:
    nowhere = np.zeros(NUM, bool)
    (row,) = measure_faults(gliding(corners(nowhere, nowhere)), ENV).to_dict("records")
    assert (row["slip"], row["flight"], row["brush"]) == (0.0, 1.0, 0.0)


def test_a_short_touch_in_a_swing_is_a_brush_and_no_slip() -> None:
    # The left foot swings for half a second and touches for 0.03 s of it.
    left = (np.arange(NUM) < 25) | (np.arange(NUM) >= 75)
    brushes = left | ((np.arange(NUM) >= 50) & (np.arange(NUM) < 53))
    right = np.ones(NUM, bool)
    (row,) = measure_faults(gliding(corners(brushes, right)), ENV).to_dict("records")
    assert row["brush"] == pytest.approx(3 / 50)
    slid = (SECONDS + 0.5) * np.hypot(SPEED, SIDEWAYS) / SPEED
    assert row["slip"] == pytest.approx(slid, rel=1e-4)


def test_a_sole_that_turns_about_a_corner_does_not_slide_there() -> None:
    # Turning left about the hip's vertical axis: a corner moves with its distance from the axis.
    qpos, qvel = np.zeros((1, 15)), np.zeros((1, 15))
    qvel[0, EULER.start] = 3.0  # yaw
    speed = corner_speeds(ENV, qpos, qvel, np.ones((1, 8), bool)).speed[0]
    # Heel and toe are 0.047 m behind and 0.153 m ahead of the ankle, 0.05 m to either side of it;
    # the ankle is 0.03 + 0.053 - 0.014 m beside the midline (flame.xml).
    inner, outer = 0.069 - 0.05, 0.069 + 0.05
    radius = [np.hypot(x, y) for x in (-0.047, 0.153) for y in (inner, outer)]
    np.testing.assert_allclose(speed, 3.0 * np.array(radius * 2), rtol=1e-5)
