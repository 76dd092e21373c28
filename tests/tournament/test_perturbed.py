"""Tests of perturbed starts, against MuJoCo's kinematics."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs import Planar7, RandomWalk, State, Terrain
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.planar7 import CONTACT_SITES, FEET
from mjxwalk.tournament.perturbed import DRAWS, perturbed, with_draws

ENV = Planar7(terrain=RandomWalk(roughness=0.004, length=8.0))
MODEL = ENV.model.mujoco


def terrain(*, row: int = 0, key: int = 0) -> Terrain:
    heights = ENV.terrain.sample(jax.random.key(7), 3)
    return Terrain(with_draws(jax.random.key(key), heights), jnp.asarray(row, jnp.int32))


def kinematics(state: State) -> Any:
    data = mujoco.MjData(MODEL)
    data.qpos[:], data.qvel[:] = np.asarray(state.qpos), np.asarray(state.qvel)
    mujoco.mj_forward(MODEL, data)
    return data


def test_draws_of_zero_are_the_usual_start() -> None:
    ground = ENV.terrain.sample(jax.random.key(7), 1)
    padded = jnp.concatenate([ground, jnp.zeros((1, DRAWS))], axis=1)
    row = jnp.zeros((), jnp.int32)
    usual, start = ENV.reset(Terrain(ground, row)), perturbed(ENV).reset(Terrain(padded, row))
    for name, expected, got in zip(State._fields, usual, start, strict=True):
        np.testing.assert_array_equal(got, expected, err_msg=name)


def test_draws_behind_the_last_node_are_no_ground() -> None:
    ground, longer = ENV.terrain.sample(jax.random.key(7), 3), terrain()
    for x in (-5.0, 0.0, 5.95, 6.0, 1000.0):
        at = jnp.asarray(x)
        usual = ENV.terrain.height(Terrain(ground, longer.row), at)
        assert ENV.terrain.height(longer, at) == usual


def test_every_trial_starts_in_another_state_and_the_same_key_gives_the_same() -> None:
    env = perturbed(ENV)
    first, second = env.reset(terrain()), env.reset(terrain(row=1))
    for name in ("qpos", "qvel", "ankle_x"):
        assert not np.array_equal(getattr(first, name), getattr(second, name))
        np.testing.assert_array_equal(getattr(first, name), getattr(env.reset(terrain()), name))
    other = env.reset(terrain(key=1))
    assert not np.array_equal(first.qvel, other.qvel)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_perturbed_walker_stands_on_level_soles_that_do_not_leave_the_ground(
    sign: float,
) -> None:
    env = perturbed(ENV)
    usual = ENV.reset(Terrain(ENV.terrain.sample(jax.random.key(7), 1), jnp.zeros((), jnp.int32)))
    height = float(min(kinematics(usual).site(name).xpos[2] for name in CONTACT_SITES))
    for corner in np.ndindex(*[2] * DRAWS):
        state = env.perturb(usual, jnp.asarray(sign * (2.0 * np.array(corner) - 1.0), jnp.float32))
        data = kinematics(state)
        for name in CONTACT_SITES:
            # float32 angles over a leg of a metre
            assert data.site(name).xpos[2] == pytest.approx(height, abs=1e-6)
        ankles = [data.body(foot).xpos[0] - data.qpos[0] for foot in FEET]
        np.testing.assert_allclose(state.ankle_x, ankles, atol=1e-6)
        # Both legs turn the same way: if one foot rises, the other is pressed down.
        assert min(velocity(data, foot)[2] for foot in FEET) <= 0.0


def test_a_push_moves_the_hip_and_leaves_the_feet_behind() -> None:
    env = perturbed(ENV)
    usual = ENV.reset(Terrain(ENV.terrain.sample(jax.random.key(7), 1), jnp.zeros((), jnp.int32)))
    data = kinematics(env.perturb(usual, jnp.asarray([0.0, 1.0, 0.0])))
    assert data.qvel[0] == pytest.approx(env.perturbation.push)
    for foot in FEET:
        # Along the ground they move by 1 - cos(0.15), a hundredth, of the push.
        assert abs(velocity(data, foot)[0]) < 0.015 * env.perturbation.push
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
