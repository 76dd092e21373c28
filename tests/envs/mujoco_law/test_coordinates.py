"""Tests of coordinates: where a tree of our own and MuJoCo's free joint put a body is the same."""

from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from c_contacts import model_of, text_of

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.derived import file_tree
from mjxwalk.envs.mujoco_law import coordinates
from mjxwalk.envs.mujoco_law.coordinates import Coordinates

CASES = Path(__file__).parents[1] / "mjcf/files/cases"
BODIES = ("h1", "walker2d", str(CASES / "ball_joints.xml"))


def somewhere(name: str) -> tuple[str, Coordinates]:
    """Returns a body's text, and where it is, turned by up to a radian about all axes."""
    text, rng = text_of(name), np.random.default_rng(1)
    num = file_tree.of_text(text).hinged.mujoco.nv
    qpos, qvel = rng.uniform(-1.0, 1.0, size=(2, num))
    return text, Coordinates(*jnp.asarray(np.stack([qpos, qvel]), jnp.float32))


def motion(model: Any, qpos: Any, qvel: Any) -> Any:
    """Returns place, attitude and velocity of each body by C MuJoCo [body, 18]."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = np.asarray(qpos), np.asarray(qvel)
    mujoco.mj_forward(model, data)
    rows, found = [], np.zeros(6)
    for body in range(1, model.nbody):
        of_body = mujoco.mjtObj.mjOBJ_XBODY
        mujoco.mj_objectVelocity(model, data, of_body, body, found, 0)
        rows.append(np.concatenate([data.xpos[body], data.xmat[body], found]))
    return np.array(rows)


@pytest.mark.parametrize("name", BODIES)
def test_both_sets_of_coordinates_move_every_body_alike(name: str) -> None:
    text, at = somewhere(name)
    model, tree = model_of(text), file_tree.of_text(text)
    ours = motion(model.mujoco, *coordinates.from_coordinates(model, at))
    canonical = motion(tree.hinged.mujoco, at.qpos, at.qvel)
    # The root's own axes may be turned in the file, and only there.
    attitude = ours[0, 3:12].reshape(3, 3) @ model.turn.T
    np.testing.assert_allclose(attitude.reshape(9), canonical[0, 3:12], atol=2e-6)
    ours[0, 3:12] = canonical[0, 3:12]
    # float32 of numbers up to some ten, as arms of a metre turn at some rad/s.
    np.testing.assert_allclose(ours, canonical, atol=2e-5)


@pytest.mark.parametrize("name", BODIES)
def test_coordinates_return_from_mujocos(name: str) -> None:
    text, at = somewhere(name)
    model = model_of(text)
    there = coordinates.from_coordinates(model, at)
    again = coordinates.to_coordinates(model, *there)
    np.testing.assert_allclose(again.qpos, at.qpos, atol=2e-6)
    np.testing.assert_allclose(again.qvel, at.qvel, atol=1e-5)


@pytest.mark.parametrize("yaw", [-3.0, -1.5, 0.1, 1.7, 3.1])
def test_quaternions_of_all_turns_have_the_length_1(yaw: float) -> None:
    text, at = somewhere("h1")
    model = model_of(text)
    for pitch, roll in ((0.0, 0.0), (1.5, 0.3), (-1.2, 3.0), (0.4, -2.9)):
        turned = at._replace(qpos=at.qpos.at[3:6].set(jnp.array([yaw, pitch, roll])))
        qpos, qvel = coordinates.from_coordinates(model, turned)
        assert float(jnp.linalg.norm(qpos[3:7])) == pytest.approx(1.0, abs=1e-6)
        again = coordinates.to_coordinates(model, qpos, qvel)
        np.testing.assert_allclose(again.qpos[3:6], [yaw, pitch, roll], atol=1e-5)
