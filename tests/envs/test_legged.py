"""Tests of starts that depart from the usual one, against MuJoCo's kinematics."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs import Flame, Planar7, RandomWalk, SerpentineWalk, State, Trial
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.bodies.planar7_body import CONTACT_SITES

ENV = Planar7(terrain=RandomWalk(roughness=0.004, length=8.0))
MODEL = ENV.model.mujoco
FEET = ("foot_left", "foot_right")
NUM_DRAWS = 3  # hips, push, pitch rate


def trial(*, row: int = 0, key: int = 0) -> Trial:
    trials = ENV.sample_trials(jax.random.key(7), 3)
    _, departing = ENV.perturbed(jax.random.key(key), trials)
    return departing.given(jnp.asarray(row, jnp.int32))


def kinematics(state: State) -> Any:
    data = mujoco.MjData(MODEL)
    data.qpos[:], data.qvel[:] = np.asarray(state.qpos), np.asarray(state.qvel)
    mujoco.mj_forward(MODEL, data)
    return data


def test_draws_of_zero_are_the_usual_start() -> None:
    usual = trial()._replace(start=None)
    found = ENV.reset(usual), ENV.reset(usual._replace(start=jnp.zeros(NUM_DRAWS)))
    for expected, got in zip(*map(jax.tree.leaves, found), strict=True):
        np.testing.assert_array_equal(got, expected)


@pytest.mark.parametrize("env", [ENV, Flame()], ids=["planar", "spatial"])
def test_perturbed_trials_are_on_the_same_ground_with_draws_to_either_side(env: Any) -> None:
    trials = env.sample_trials(jax.random.key(7), 50)
    same, departing = env.perturbed(jax.random.key(0), trials)
    assert same == env
    np.testing.assert_array_equal(departing.heights, trials.heights)
    assert departing.load is None and departing.start.shape == (50, len(env.START_DEPARTURES))
    assert (np.abs(departing.start) <= 1.0).all()
    assert (departing.start.min(axis=0) < -0.5).all() and (departing.start.max(axis=0) > 0.5).all()


def test_every_trial_starts_in_another_state_and_the_same_key_gives_the_same() -> None:
    first, second = ENV.reset(trial()), ENV.reset(trial(row=1))
    for name in ("qpos", "qvel", "ankle_x"):
        assert not np.array_equal(getattr(first, name), getattr(second, name))
        np.testing.assert_array_equal(getattr(first, name), getattr(ENV.reset(trial()), name))
    other = ENV.reset(trial(key=1))
    assert not np.array_equal(first.qvel, other.qvel)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_perturbed_walker_stands_on_level_soles_that_do_not_leave_the_ground(
    sign: float,
) -> None:
    usual = ENV.reset(trial()._replace(start=None))
    height = float(min(kinematics(usual).site(name).xpos[2] for name in CONTACT_SITES))
    for corner in np.ndindex(*[2] * NUM_DRAWS):
        state = ENV.depart(usual, jnp.asarray(sign * (2.0 * np.array(corner) - 1.0), jnp.float32))
        data = kinematics(state)
        for name in CONTACT_SITES:
            # float32 angles over a leg of a metre
            assert data.site(name).xpos[2] == pytest.approx(height, abs=1e-6)
        ankles = [data.body(foot).xpos[0] - data.qpos[0] for foot in FEET]
        np.testing.assert_allclose(state.ankle_x, ankles, atol=1e-6)
        # Both legs turn the same way: if one foot rises, the other is pressed down.
        assert min(velocity(data, foot)[2] for foot in FEET) <= 0.0


def test_a_push_moves_the_hip_and_leaves_the_feet_behind() -> None:
    usual = ENV.reset(trial()._replace(start=None))
    data = kinematics(ENV.depart(usual, jnp.asarray([0.0, 1.0, 0.0])))
    push = ENV.START_DEPARTURES["push"]
    assert data.qvel[0] == pytest.approx(push)
    for foot in FEET:
        # Along the ground they move by 1 - cos(0.15), a hundredth, of the push.
        assert abs(velocity(data, foot)[0]) < 0.015 * push
        assert spin(data, foot) == pytest.approx(0.0, abs=1e-6)


def velocity(data: Any, body: str) -> Any:
    """Returns the velocity of a link's origin, m/s."""
    return _motion(data, body)[3:]


def spin(data: Any, body: str) -> float:
    """Returns how fast a link pitches, rad/s."""
    return float(_motion(data, body)[1])


def _motion(data: Any, body: str) -> Any:
    motion = np.zeros(6)
    kind = mujoco.mjtObj.mjOBJ_XBODY
    mujoco.mj_objectVelocity(MODEL, data, kind, MODEL.body(body).id, motion, 0)
    return motion


FLAME = Flame(terrain=SerpentineWalk(length=6.0))


def spatial_trial(draws: list[float]) -> Trial:
    trials = FLAME.sample_trials(jax.random.key(7), 1)
    return trials._replace(start=jnp.array([draws])).given(jnp.zeros((), jnp.int32))


def test_a_spatial_start_without_perturbation_is_the_usual_one() -> None:
    trial = spatial_trial([0.0, 0.0, 0.0])
    found = FLAME.reset(trial._replace(start=None)), FLAME.reset(trial)
    for expected, got in zip(*map(jax.tree.leaves, found), strict=True):
        np.testing.assert_array_equal(got, expected)


def test_every_spatial_trial_starts_in_another_state() -> None:
    _, trials = FLAME.perturbed(jax.random.key(0), FLAME.sample_trials(jax.random.key(7), 2))
    first, second = (FLAME.reset(trials.given(jnp.asarray(row, jnp.int32))) for row in (0, 1))
    assert not np.array_equal(first.qpos, second.qpos)
    assert not np.array_equal(first.qvel, second.qvel)


def test_a_spatial_push_tips_the_walker_about_its_stance_foot() -> None:
    model = FLAME.model.mujoco
    data = mujoco.MjData(model)
    velocity = np.zeros(6)

    def sideways(draws: list[float]) -> tuple[float, float]:
        """Returns how fast hip and stance sole move along y, m/s."""
        state, joints = FLAME.reset(spatial_trial(draws)), list(FLAME.anatomy.joint_coordinate)
        data.qpos[:] = np.asarray(state.qpos)[joints]
        data.qvel[:] = np.asarray(state.qvel)[joints]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        site = model.site("heel_in_right").id
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, site, velocity, 0)
        return float(data.qvel[1]), float(velocity[4])

    hip, sole = np.subtract(sideways([0.0, 1.0, 0.0]), sideways([0.0, 0.0, 0.0]))
    assert hip == pytest.approx(0.05, rel=1e-5)
    # The leg is bent and tilted, so that the sole is not just a leg's length below the hip.
    assert abs(sole) < 0.05 * hip
