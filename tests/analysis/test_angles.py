"""Tests of angles by role over a step."""

import jax
import numpy as np
from analysis.walking import STRIDE_FRAMES, recording, walk

from mjxwalk.analysis import angles, roles
from mjxwalk.analysis.angles import add_steps, angle_density, empty_density, step_angles
from mjxwalk.envs import Flame, Planar7
from mjxwalk.envs.bodies.flame_body import PITCH, ROLL
from mjxwalk.replay import Recording

ENV = Planar7()
TORSO, STANCE_THIGH, INTER_LEG, STANCE_KNEE, SWING_KNEE, STANCE_ANKLE, SWING_ANKLE = range(7)


def posed(frames: int = 600, *, fell: bool = False) -> Recording:
    """Returns walking whose knee bends as its leg swings, torso 10 degrees forward."""
    made = recording([walk(frames)], fell=[fell])
    qpos = made.states.qpos
    qpos[:, 0, 2] = np.radians(10.0)
    for first, shift in ((3, 0), (6, STRIDE_FRAMES // 2)):
        phase = (np.arange(frames) + shift) % STRIDE_FRAMES
        # A leg is the swing leg from its lift-off at 72 until the other one lifts off at 12.
        swing = ((phase - 72) % STRIDE_FRAMES) / 60
        qpos[:, 0, first] = np.where(swing < 1, np.radians(30.0), 0.0)
        qpos[:, 0, first + 1] = np.where(swing < 1, np.radians(60.0) * swing, 0.0)
        qpos[:, 0, first + 2] = np.radians(np.where(swing < 1, -5.0, 5.0))
    return made


def test_angles_are_by_role_on_either_side() -> None:
    steps = step_angles(posed(), ENV, slices=10, settled=1.0)
    # Roles change every 0.6 s from 0.12 s on; of whole steps, those from 1.32 s to 5.52 s count.
    assert steps.shape == (7, 10, 7)
    np.testing.assert_allclose(steps[..., TORSO], 10.0, atol=1e-4)
    np.testing.assert_allclose(steps[..., STANCE_THIGH], -10.0, atol=1e-4)  # from the vertical
    np.testing.assert_allclose(steps[..., INTER_LEG], 30.0, atol=1e-4)
    np.testing.assert_allclose(steps[..., STANCE_KNEE], 0.0, atol=1e-4)
    np.testing.assert_allclose(steps[..., STANCE_ANKLE], 5.0, atol=1e-4)
    np.testing.assert_allclose(steps[..., SWING_ANKLE], -5.0, atol=1e-4)
    # The knee's ramp is met at the middles of the slices.
    expected = 60.0 * (np.arange(10) + 0.5) / 10
    np.testing.assert_allclose(steps[..., SWING_KNEE], np.tile(expected, (7, 1)), atol=1e-3)


def test_steps_of_trials_with_a_fall_do_not_count() -> None:
    assert step_angles(posed(fell=True), ENV).shape == (0, angles.SLICES, 7)
    assert angle_density([posed(fell=True)], ENV).steps == 0


def test_the_most_frequent_state_of_every_slice_is_white() -> None:
    density = angle_density([posed(), posed(900)], ENV)
    np.testing.assert_array_equal(density.whiteness.max(axis=2), 1.0)
    assert density.steps == density.counts[SWING_KNEE].sum(axis=1).max()


def test_counts_are_a_histogram_of_each_slice() -> None:
    draws = np.random.default_rng(0).normal(0.0, 8.0, (400, 5, 7))
    density = add_steps(empty_density(slices=5, bins=30), draws)
    for angle, edges in enumerate(density.edges):
        for place in range(5):
            expected, _ = np.histogram(draws[:, place, angle], edges)
            np.testing.assert_array_equal(density.counts[angle, place], expected)
    np.testing.assert_allclose(density.mean, draws.mean(axis=0).T)


def test_adding_steps_by_and_by_is_adding_them_at_once() -> None:
    draws = np.random.default_rng(1).normal(0.0, 20.0, (30, 4, 7))
    at_once = add_steps(empty_density(slices=4, bins=9), draws)
    parts = empty_density(slices=4, bins=9)
    for part in np.split(draws, 3):
        parts = add_steps(parts, part)
    np.testing.assert_array_equal(parts.counts, at_once.counts)
    assert parts.steps == at_once.steps == 30


def test_no_steps_have_no_mean() -> None:
    density = empty_density(slices=3, bins=4)
    assert np.isnan(density.mean).all() and not density.whiteness.any()


def test_the_roll_of_a_spatial_body_is_told_towards_the_stance_foot() -> None:
    env = Flame()
    start, frames = env.reset(env.level_trials().given(0)), 600
    states = jax.tree.map(lambda leaf: np.repeat(np.asarray(leaf)[None], frames, axis=0), start)
    states.qpos[:, PITCH], states.qpos[:, ROLL] = np.radians(5.0), np.radians(10.0)
    left = np.arange(frames) // 50 % 2 == 0  # roles change every half second
    touching = np.repeat(np.stack([left, ~left], axis=1), 4, axis=1)
    states = jax.tree.map(lambda leaf: leaf[:, None], states._replace(touching=touching))
    time = (0.01 * np.arange(frames, dtype=np.float32))[:, None]
    steps = step_angles(Recording(time, np.zeros((frames, 1), bool), states), env)
    torso, roll = (roles.SPATIAL.names.index(name) for name in ("torso", "roll"))
    np.testing.assert_allclose(steps[..., torso], 5.0, atol=1e-4)
    np.testing.assert_allclose(np.abs(steps[..., roll]), 10.0, atol=1e-4)
    signs = np.sign(steps[:, 0, roll])
    assert len(signs) >= 4 and (signs[1:] == -signs[:-1]).all()
