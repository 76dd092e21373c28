"""A legged body of a file alone: its tree, anatomy, springs and start, all taken from its MJCF.

What a file says by names: bodies, joints and sites of a leg end in `_left` or `_right`; joints
named `hip_`, `knee_` and `ankle_` are these; the sites of the last body of a leg are where it
touches the ground.
"""

import functools
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from mjxwalk.envs import body_file, body_legs, dynamics, floating
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.anatomy import HINGE, KINDS, LEGS, Anatomy, Sense, side_of, without_side
from mjxwalk.envs.body_contract import Contract, Joint, Link
from mjxwalk.envs.derived_anatomy import Strength, derive
from mjxwalk.envs.legged_body import Sprung

# Joints of the first body: in the plane, and in space, in this order.
ROOTS = (
    (("slide", "x"), ("slide", "z"), ("hinge", "y")),
    (
        ("slide", "x"),
        ("slide", "y"),
        ("slide", "z"),
        ("hinge", "z"),
        ("hinge", "y"),
        ("hinge", "x"),
    ),
)
STRENGTH = 0.5  # torque of a motor without limits for an action of 1, over weight times leg; ours


class Stance(NamedTuple):
    """A body with its feet on level ground at height zero.

    Attributes:
      qpos: coordinates, m and rad.
      touching: which contact points are as low as the lowest.
      ankle_x: how far each foot's origin is ahead of the root, m.
    """

    qpos: Float[np.ndarray, " coordinate"]
    touching: Bool[np.ndarray, " point"]
    ankle_x: Float[np.ndarray, " leg"]


@functools.cache
def hinged_model(text: str) -> dynamics.Model:
    """Returns the compiled body with a joint for each of the root's coordinates.

    Raises:
      ValueError: the text is no MJCF, or holds what no body may.
    """
    return dynamics.compile_model(body_file.read(text))


@functools.cache
def floating_model(text: str) -> dynamics.Model | None:
    """Returns the compiled body with a free root; None of a body in the plane."""
    if anatomy(text).root.is_planar:
        return None
    root = str(hinged_model(text).mujoco.body(1).name)
    return dynamics.compile_model(floating.freed(body_file.read(text), root))


@functools.cache
def anatomy(text: str) -> Anatomy:
    """Returns the anatomy of a body.

    Raises:
      ValueError: it has no root, feet or motors that are known here.
    """
    model = hinged_model(text).mujoco
    _check_tree(model)
    joints = [str(model.joint(joint).name) for joint in range(model.njnt)]
    driven = [int(model.actuator_trnid[motor][0]) for motor in range(model.nu)]
    if not driven:
        raise ValueError("the body has no motors; add <motor joint=.../> for each driven joint")
    contract = _contract(model, joints, driven)
    body_file.check_world(model, contract)
    body_legs.check_joints(model, contract)
    body_legs.check_motors(model, contract)
    points = _points(model)
    limits = body_legs.torque_limits_of(model, driven)
    weight = -model.opt.gravity[2] * model.body_subtreemass[0]
    usual = STRENGTH * weight * _height(model)
    return derive(
        model,
        name=str(model.names[: model.names.index(b"\0")].decode()) or "body",
        motors=[joints[joint] for joint in driven],
        points=points,
        senses=_senses(model, joints),
        limits=limits,
        strength=Strength(
            "torque",
            [float(high) if np.isfinite(high) else usual for _, high in limits],
            damping=0.01 * usual,
        ),
    )


@functools.cache
def springs(text: str) -> Sprung | None:
    """Returns the passive springs and dampers of the joints."""
    model, num = hinged_model(text).mujoco, anatomy(text).root.num
    found = body_legs.springs(model, [[joint] for joint in range(num, model.njnt)])
    return None if found is None else Sprung(np.arange(model.njnt - num), found)


@functools.cache
def stance(text: str, angles: tuple[tuple[str, float], ...]) -> Stance:
    """Returns how the body stands with its joints at some angles, by name, the others at zero.

    Raises:
      ValueError: it has no joint of a name.
    """
    found, model = anatomy(text), hinged_model(text).mujoco
    data = mujoco.MjData(model)
    for name, angle in angles:
        data.qpos[found.place(name)] = angle
    mujoco.mj_kinematics(model, data)
    lowest = np.array([data.site(each.name).xpos[2] - each.radius for each in found.points])
    data.qpos[found.root.height] = -lowest.min()
    ankles = np.array([data.body(leg.foot).xpos[0] for leg in found.legs])
    return Stance(
        data.qpos.astype(np.float32), lowest - lowest.min() < 1e-3, ankles.astype(np.float32)
    )


def _contract(model: Any, joints: list[str], driven: list[int]) -> Contract:
    """Returns what the checks of our own bodies' files hold this one to."""
    num = int(model.body_jntnum[1])
    axes = [tuple(int(round(value)) for value in model.jnt_axis[joint]) for joint in range(num)]
    root = tuple(
        Joint(joints[joint], int(model.jnt_type[joint]), (x, y, z))
        for joint, (x, y, z) in enumerate(axes)
    )
    sites = [
        (str(model.site(site).name), str(model.body(int(model.site_bodyid[site])).name))
        for site in range(model.nsite)
    ]
    motors = dict.fromkeys(joints[joint] for joint in driven if joint >= num)
    torso = Link(str(model.body(1).name), "world", root)
    return Contract(kind="own", links=(torso,), sites=tuple(sites), motors=tuple(motors))


def _check_tree(model: Any) -> None:
    """Raises ValueError unless the tree is one that `mjxwalk.envs.trees` moves."""
    for kind, num in (("body", model.nbody), ("joint", model.njnt), ("site", model.nsite)):
        for each in range(num):
            if not getattr(model, kind)(each).name:
                raise ValueError(
                    f"a {kind} has no name, and its name says whose leg it is; add one"
                )
    for joint in range(model.njnt):
        name, axis = model.joint(joint).name, model.jnt_axis[joint]
        if int(model.jnt_type[joint]) not in KINDS:
            raise ValueError(
                f"joint {name} is a ball or free joint; use hinges, of the root slides too"
            )
        if not np.isclose(np.abs(axis).max(), 1.0) or np.any(model.jnt_pos[joint]):
            raise ValueError(
                f"joint {name} must be at its body's origin and along one of its axes; move and "
                "turn the body's parts instead"
            )
        if int(model.jnt_bodyid[joint]) > 1 and int(model.jnt_type[joint]) != HINGE:
            raise ValueError(f"joint {name} is a slide, and only the root may have slides")
    for body in range(1, model.nbody):
        name = model.body(body).name
        if not np.allclose(model.body_quat[body], [1.0, 0.0, 0.0, 0.0]):
            raise ValueError(f"body {name} is turned; leave its axes along the world's")
        if int(model.body_parentid[body]) == 0 and (body > 1 or np.any(model.body_pos[body])):
            raise ValueError(
                f"body {name} must be the only one in the world, at 0 0 0; a trial puts it on the "
                "ground by itself"
            )
    _check_root(model)


def _check_root(model: Any) -> None:
    found = tuple(
        (KINDS[int(model.jnt_type[joint])], _axis(model.jnt_axis[joint]))
        for joint in range(int(model.body_jntnum[1]) if model.nbody > 1 else 0)
    )
    if found not in ROOTS:
        words = [", ".join(f"{kind} {axis}" for kind, axis in root) for root in ROOTS]
        raise ValueError(
            f"the first body must have the joints {words[0]}, or {words[1]}, in this order, and "
            f"has {', '.join(f'{kind} {axis}' for kind, axis in found) or 'none'}"
        )


def _axis(axis: Float[np.ndarray, "3"]) -> str:
    name = "xyz"[int(np.argmax(np.abs(axis)))]
    return name if axis.max() > 0.5 else f"-{name}"


def _points(model: Any) -> list[str]:
    """Returns the sites of the last body of each leg, left, then right."""
    parents = set(model.body_parentid[1:].tolist())
    feet = [body for body in range(1, model.nbody) if body not in parents]
    points = [
        str(model.site(site).name)
        for side in LEGS
        for site in range(model.nsite)
        if int(model.site_bodyid[site]) in feet
        and side_of(str(model.body(int(model.site_bodyid[site])).name)) == side
    ]
    sides = {side_of(str(model.body(int(model.site(each).bodyid[0])).name)) for each in points}
    if sides != set(LEGS):
        raise ValueError(
            "the body has no feet: the last body of each leg must be named ..._left or ..._right "
            "and have sites, where it touches the ground"
        )
    return points


def _senses(model: Any, joints: list[str]) -> tuple[Sense, ...]:
    root = int(model.body_jntnum[1])
    legs = {side: [each for each in joints[root:] if side_of(each) == side] for side in LEGS}
    left, right = ([without_side(each) for each in legs[side]] for side in LEGS)
    if left != right or len(left) + len(right) != len(joints) - root:
        raise ValueError(
            "every joint but the root's must be named ..._left or ..._right, the same of both legs "
            f"in the same order; got {', '.join(joints[root:])}"
        )
    angles = (*legs["left"], *legs["right"])
    planar = root == len(ROOTS[0])
    torso = (
        (
            Sense("pitch", "rad", "of the torso, forward lean positive"),
            Sense("pitch_rate", "rad/s", "of the torso, forward lean positive"),
        )
        if planar
        else (
            Sense("torso", "rad", "its Euler angles (z-y-x)", ("yaw", "pitch", "roll")),
            Sense("torso_rate", "rad/s", "of its Euler angles", ("yaw", "pitch", "roll")),
        )
    )
    return (
        Sense("time", "s", "since the start of the trial"),
        *torso,
        Sense("angle", "rad", "of each leg's joints", angles),
        Sense("rate", "rad/s", "of each leg's joints", angles),
        Sense("contact", "", "whether the left and the right foot touch the ground", LEGS),
        Sense("ankle_x", "m", "how far each foot's origin is ahead of the torso's", LEGS),
    )


def _height(model: Any) -> float:
    """Returns how high the root is over its lowest site with all joints at zero, m."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return -float(data.site_xpos[:, 2].min())
