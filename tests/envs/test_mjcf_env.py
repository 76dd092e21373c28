"""Tests of the environment of any body: how its trials start, against C MuJoCo's kinematics."""

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import robots
from mjxwalk.envs import MjcfEnv
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import reader


def env_of(name: str) -> MjcfEnv:
    """Returns the environment of a body that ships."""
    return MjcfEnv.of(reader.read(robots.path(name)).text)


def velocities(env: MjcfEnv, state: Any) -> tuple[Any, Any]:
    """Returns the velocities of the root's origin and of the places right below it, m/s."""
    model = env.model.mujoco
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = state.qpos, state.qvel
    mujoco.mj_forward(model, data)
    root = next(body for body in range(1, model.nbody) if model.body_mass[body] > 0)
    linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    sole = data.xpos[root] - [0.0, 0.0, env.stance.height]
    mujoco.mj_jac(model, data, linear, angular, sole, root)
    below = linear @ data.qvel
    mujoco.mj_jac(model, data, linear, angular, data.xpos[root], root)
    return linear @ data.qvel, below


@pytest.mark.parametrize(("name", "across"), [("walker2d", False), ("h1", True)])
def test_a_perturbed_walker_tips_about_its_soles(name: str, across: bool) -> None:
    env = env_of(name)
    given = env.level_trials().given(0)
    rest = env.start(given)
    tips = env.start(given._replace(start=jnp.asarray([1.0, -1.0])))
    np.testing.assert_array_equal(tips.qpos, rest.qpos)
    np.testing.assert_array_equal(rest.qvel, 0.0)

    of_root, of_sole = velocities(env, tips)
    pace = np.sqrt(9.81 * env.stance.height)
    forward, sideways = env.START_DEPARTURES.values()
    assert of_root[0] == pytest.approx(forward * pace, rel=1e-4)
    assert of_root[1] == pytest.approx(-sideways * pace if across else 0.0, rel=1e-4)
    # float32 velocities
    np.testing.assert_allclose(of_sole, 0.0, atol=1e-5)


def test_starts_are_drawn_between_the_largest_departures() -> None:
    env = env_of("walker2d")
    same, trials = env.perturbed(jnp.zeros(2, jnp.uint32), env.level_trials(200))
    assert same is env
    drawn = np.asarray(trials.start)
    assert drawn.shape == (200, 2)
    assert -1.0 <= drawn.min() < -0.9 and 0.9 < drawn.max() <= 1.0
