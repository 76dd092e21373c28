"""Tests of perturbed starts, against MuJoCo's kinematics."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs import Flame, Planar7, RandomWalk, SerpentineWalk, State, Terrain
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.flame_body import COORDINATE
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


FLAME = Flame(terrain=SerpentineWalk(length=6.0))


def spatial_terrain(draws: list[float] | None = None, *, row: int = 0) -> Terrain:
    heights = with_draws(jax.random.key(0), FLAME.terrain.sample(jax.random.key(7), 2))
    if draws is not None:
        heights = heights.at[row, -1, :DRAWS].set(jnp.array(draws))
    return Terrain(heights, jnp.asarray(row, jnp.int32))


def test_a_spatial_start_without_perturbation_is_the_usual_one_on_the_same_ground() -> None:
    ground = spatial_terrain([0.0, 0.0, 0.0])
    usual = FLAME.reset(ground._replace(heights=ground.heights[:, :-1]))
    for name, got in perturbed(FLAME).reset(ground)._asdict().items():
        np.testing.assert_array_equal(got, getattr(usual, name), err_msg=name)
    for x in (0.0, 3.95, 4.0, 1000.0):
        at = jnp.asarray(x), jnp.asarray(0.3)
        without = ground._replace(heights=ground.heights[:, :-1])
        assert FLAME.terrain.height(ground, *at) == FLAME.terrain.height(without, *at)


def test_every_spatial_trial_starts_in_another_state() -> None:
    env = perturbed(FLAME)
    first, second = env.reset(spatial_terrain()), env.reset(spatial_terrain(row=1))
    assert not np.array_equal(first.qpos, second.qpos)
    assert not np.array_equal(first.qvel, second.qvel)


def test_a_spatial_push_tips_the_walker_about_its_stance_foot() -> None:
    model = FLAME.model.mujoco
    data = mujoco.MjData(model)
    velocity = np.zeros(6)

    def sideways(draws: list[float]) -> tuple[float, float]:
        """Returns how fast hip and stance sole move along y, m/s."""
        state = perturbed(FLAME).reset(spatial_terrain(draws))
        data.qpos[:] = np.asarray(state.qpos)[COORDINATE]
        data.qvel[:] = np.asarray(state.qvel)[COORDINATE]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        site = model.site("heel_in_right").id
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, site, velocity, 0)
        return float(data.qvel[1]), float(velocity[4])

    hip, sole = np.subtract(sideways([0.0, 1.0, 0.0]), sideways([0.0, 0.0, 0.0]))
    assert hip == pytest.approx(0.05, rel=1e-5)
    # The leg is bent and tilted, so that the sole is not just a leg's length below the hip.
    assert abs(sole) < 0.05 * hip
