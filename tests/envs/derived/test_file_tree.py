"""The tree that our code makes of a file moves as the file's own model does in C MuJoCo."""

from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import numpy as np
import pytest

from mjxwalk import robots
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.derived import file_tree
from mjxwalk.envs.derived.source import BALL
from mjxwalk.envs.mjcf import reader

ASSETS = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
TOYS = Path(__file__).parents[2] / "toys"
FILES = {
    **{name: robots.path(name) for name in ("h1", "g1", "walker2d")},
    "Gymnasium's ant": ASSETS / "ant.xml",
    "a ball, slides, and a root on its side": TOYS / "odd_biped.xml",
}
# What acts in both but is not of the tree.
DISABLED = ("CONTACT", "CONSTRAINT", "ACTUATION")


class Both(NamedTuple):
    """A body as the file has it, and as a tree of ours; each a model and its data.

    Attributes:
      turned: takes the file's world to the tree's.
      square: takes the axes of the file's root to those of the tree's root.
    """

    tree: file_tree.FileTree
    file: tuple[Any, Any]
    ours: tuple[Any, Any]
    turned: Any
    square: Any


def both(path: Path) -> Both:
    tree = file_tree.of_text(reader.read(path).text)
    found: list[tuple[Any, Any]] = []
    for model in (mujoco.MjModel.from_xml_string(reader.read(path).text), tree.hinged.mujoco):
        for each in DISABLED:
            model.opt.disableflags |= getattr(mujoco.mjtDisableBit, f"mjDSBL_{each}")
        found.append((model, mujoco.MjData(model)))
    file, ours = found
    file[1].qpos[:] = tree.source.data.qpos
    starts = [*tree.attitude, *(each.start for each in tree.joints)]
    ours[1].qpos[-len(starts) :] = starts
    for model, data in found:
        mujoco.mj_kinematics(model, data)
    turned = best_turn(*(data.xpos[1:] - data.xpos[1] for _, data in (file, ours)))
    square = ours[1].xmat[1].reshape(3, 3).T @ turned @ file[1].xmat[1].reshape(3, 3)
    return Both(tree, file, ours, turned, square)


def best_turn(one: Any, other: Any) -> Any:
    """Returns the turn about the vertical that takes places to others."""
    flat = one[:, :2].T @ other[:, :2]
    angle = np.arctan2(flat[0, 1] - flat[1, 0], flat[0, 0] + flat[1, 1])
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])


def shake(pair: Both, random: Any) -> None:
    """Puts both into the same random pose, with the same rates and torques of their joints."""
    tree, (model, data), (ours, moved) = pair.tree, pair.file, pair.ours
    root = ours.njnt - len(tree.joints)
    moved.qpos[:], moved.qvel[:] = random.uniform(-1, 1, (2, ours.nv))
    moved.qfrc_applied[:] = 10.0 * random.normal(size=ours.nv)
    moved.qfrc_applied[:root] = 0.0
    for place, each in enumerate(tree.joints, root):
        if int(model.jnt_type[each.joint]) == BALL:
            moved.qfrc_applied[place] = 0.0
            continue
        data.qpos[int(model.jnt_qposadr[each.joint])] = moved.qpos[place]
        data.qfrc_applied[int(model.jnt_dofadr[each.joint])] = moved.qfrc_applied[place]
    mujoco.mj_kinematics(ours, moved)
    mujoco.mj_comPos(ours, moved)
    mujoco.mj_comVel(ours, moved)
    turn_balls(pair)
    match_rates(pair)


def turn_balls(pair: Both) -> None:
    """Places the file's root, and turns its free and ball joints, as the tree's bodies are."""
    (model, data), (_, moved) = pair.file, pair.ours
    axes = np.array([pair.turned.T @ each.reshape(3, 3) for each in moved.xmat])
    axes[1] = axes[1] @ pair.square
    if pair.tree.planar:
        data.qpos[:3] = moved.qpos[:3]  # in the same order, about an origin of their own
        return
    data.qpos[:3] = moved.xpos[1] @ pair.turned
    mujoco.mju_mat2Quat(data.qpos[3:7], axes[1].reshape(-1))
    for joint in np.flatnonzero(model.jnt_type == BALL):
        body, at = int(model.jnt_bodyid[joint]), int(model.jnt_qposadr[joint])
        still = np.zeros(9)
        mujoco.mju_quat2Mat(still, model.body_quat[body])
        held = axes[int(model.body_parentid[body])] @ still.reshape(3, 3)
        mujoco.mju_mat2Quat(data.qpos[at : at + 4], (held.T @ axes[body]).reshape(-1))


def match_rates(pair: Both) -> None:
    """Gives the file's joints the rates by which all its bodies turn and move as the tree's do."""
    (model, data), (ours, moved) = pair.file, pair.ours
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    wanted: list[Any] = []
    rows: list[Any] = []
    for body in range(1, model.nbody):
        linear, angular = np.zeros((2, 3, model.nv))
        mujoco.mj_jacBody(model, data, linear, angular, body)
        rows += [angular, linear]
        wanted += list(motion(ours, moved, body) @ pair.turned)
    data.qvel[:] = np.linalg.lstsq(np.concatenate(rows), np.concatenate(wanted))[0]


def motion(model: Any, data: Any, body: int) -> Any:
    """Returns a body's angular velocity and that of its origin, world axes."""
    found = np.zeros(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, found, 0)
    return found.reshape(2, 3)


def acceleration(model: Any, data: Any, body: int) -> Any:
    """Returns a body's angular acceleration and that of its origin, world axes."""
    found = np.zeros(6)
    mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, found, 0)
    return found.reshape(2, 3)


@pytest.mark.parametrize("name", FILES)
def test_a_tree_accelerates_as_the_file_does_in_c_mujoco(name: str) -> None:
    pair = both(FILES[name])
    (model, data), (ours, moved) = pair.file, pair.ours
    if BALL in model.jnt_type:  # whose springs and dampers are those of three hinges here
        for each in (model, ours):
            each.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_SPRING
            each.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_DAMPER
    random = np.random.default_rng(0)
    for _ in range(10):
        shake(pair, random)
        for each in ((model, data), (ours, moved)):
            mujoco.mj_forward(*each)
            mujoco.mj_rnePostConstraint(*each)
        np.testing.assert_allclose(
            (data.xpos[1:] - data.xpos[1]) @ pair.turned.T,
            moved.xpos[1:] - moved.xpos[1],
            atol=1e-9,
        )
        for body in range(1, model.nbody):
            for what in (motion, acceleration):
                found = what(ours, moved, body)
                expected = what(model, data, body) @ pair.turned.T
                np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6)
        assert np.abs(data.qacc).max() > 1.0
