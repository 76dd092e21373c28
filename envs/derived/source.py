"""The model that a body's MJCF compiles to, and the pose that trials start in."""

import functools
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.envs import body_xml
from mjxwalk.envs._mujoco import compiled, mujoco, refusing
from mjxwalk.envs.anatomy import HINGE, SLIDE

BALL, FREE = int(mujoco.mjtJoint.mjJNT_BALL), int(mujoco.mjtJoint.mjJNT_FREE)
PLANE, MESH = int(mujoco.mjtGeom.mjGEOM_PLANE), int(mujoco.mjtGeom.mjGEOM_MESH)
# Keyframes that are a start, best first; else it is the pose with all coordinates at their zero.
STARTS = ("knees_bent", "home", "stand", "standing", "start", "init")


class Pose(NamedTuple):
    """A model in one pose.

    Attributes:
      model: the `mujoco.MjModel`.
      data: the `mujoco.MjData` with everything's place.
    """

    model: Any
    data: Any


@functools.cache
def model(text: str) -> Any:
    """Returns the `mujoco.MjModel` of a body's MJCF, as the file says it.

    Raises:
      ValueError: it holds what no body may, or MuJoCo cannot compile it.
    """
    xml = body_xml.checked(text)  # a run's text may come from a stranger
    with refusing("MuJoCo cannot read it"):
        spec = mujoco.MjSpec.from_string(xml)
    return compiled(spec)


@functools.cache
def start(text: str) -> Pose:
    """Returns the model in the pose that trials start in.

    That is a keyframe's, or that of the number `init_qpos`, or all coordinates at zero, or as near
    to it as their ranges allow.
    """
    found = model(text)
    data = mujoco.MjData(found)
    names = [str(found.key(key).name).lower() for key in range(found.nkey)]
    best = [names.index(name) for name in STARTS if name in names]
    numbers = [str(found.numeric(number).name) for number in range(found.nnumeric)]
    if best:
        data.qpos[:] = found.key_qpos[best[0]]
    elif "init_qpos" in numbers and found.numeric("init_qpos").data.size == found.nq:
        data.qpos[:] = found.numeric("init_qpos").data
    for joint in range(found.njnt):
        if found.jnt_limited[joint] and int(found.jnt_type[joint]) in (HINGE, SLIDE):
            place = int(found.jnt_qposadr[joint])
            data.qpos[place] = np.clip(data.qpos[place], *found.jnt_range[joint])
    mujoco.mj_kinematics(found, data)
    mujoco.mj_comPos(found, data)
    return Pose(found, data)


def joints_of(found: Any, body: int) -> range:
    """Returns the numbers of a body's joints."""
    first = int(found.body_jntadr[body])
    return range(first, first + int(found.body_jntnum[body]))


def geoms_of(found: Any, body: int) -> range:
    """Returns the numbers of a body's geoms."""
    first = int(found.body_geomadr[body])
    return range(first, first + int(found.body_geomnum[body]))


def parents(found: Any, body: int) -> list[int]:
    """Returns a body and those that carry it, up to the root, which is body 1."""
    chain: list[int] = []
    while body:
        chain.append(body)
        body = int(found.body_parentid[body])
    return chain


def kind_of(found: Any, joint: int) -> str:
    """Returns what a joint is, as MJCF calls it."""
    kinds: Mapping[int, str] = {HINGE: "hinge", SLIDE: "slide", BALL: "ball", FREE: "free"}
    return kinds[int(found.jnt_type[joint])]


def quaternion(turn: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, "4"]:
    """Returns a rotation as a quaternion, w first."""
    found = np.zeros(4)
    mujoco.mju_mat2Quat(found, np.ascontiguousarray(turn, np.float64).reshape(9))
    return found
