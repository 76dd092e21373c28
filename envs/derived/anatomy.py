"""The anatomy of any file's body: mirror partners, legs and roles, motors, points and senses."""

import functools
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.anatomy import (
    KINDS,
    MIRROR,
    Anatomy,
    ContactPoint,
    Coordinate,
    Leg,
    Motor,
    Root,
    Sense,
    side_of,
    without_side,
)
from mjxwalk.envs.derived import file_tree
from mjxwalk.envs.derived import motors as mjcf_motors
from mjxwalk.envs.derived.file_tree import FileTree

GRAVITY = 9.81  # m/s^2, as in MuJoCo
ACROSS = 0.7  # a hinge whose axis is along y so far bends the leg forward or backward; ours
SPATIAL_ROOT = Root(num=6, forward=0, sideways=1, height=2, yaw=3, pitch=4, roll=5)
PLANAR_ROOT = Root(num=3, forward=0, sideways=None, height=1, yaw=None, pitch=2, roll=None)


class Stance(NamedTuple):
    """A body with its feet on level ground at height zero, as trials start.

    Attributes:
      qpos: coordinates, m and rad.
      touching: which contact points are about as low as the lowest.
      ankle_x: how far each foot's origin is ahead of the root, m.
      feet: how high each foot's origin is, m.
      height: of the root, m.
      weight: N.
    """

    qpos: Float[np.ndarray, " coordinate"]
    touching: Any
    ankle_x: Float[np.ndarray, " leg"]
    feet: Float[np.ndarray, " leg"]
    height: float
    weight: float

    @property
    def time(self) -> float:
        """Of a fall from the root's height, over the square root of two, s."""
        return float(np.sqrt(self.height / GRAVITY))


@functools.cache
def stance(text: str, angles: tuple[tuple[str, float], ...] = ()) -> Stance:
    """Returns how a body stands: as its file says, but for some joints by name.

    Raises:
      ValueError: the engines cannot move it, or it has no joint of a name, or not that far.
    """
    tree = file_tree.of_text(text)
    model = tree.hinged.mujoco
    data = mujoco.MjData(model)
    root = PLANAR_ROOT if tree.planar else SPATIAL_ROOT
    data.qpos[root.num - len(tree.attitude) : root.num] = tree.attitude
    data.qpos[root.num :] = [each.start for each in tree.joints]
    names = [each.name for each in tree.joints]
    for name, angle in angles:
        if name not in names:
            raise ValueError(f"the body has no joint {name}; it has {', '.join(names)}")
        joint = root.num + names.index(name)
        lowest, highest = model.jnt_range[joint]
        if model.jnt_limited[joint] and not lowest <= angle <= highest:
            raise ValueError(
                f"joint {name} turns from {lowest:.3g} to {highest:.3g}, and is to start at "
                f"{angle:g}"
            )
        data.qpos[joint] = angle
    mujoco.mj_kinematics(model, data)
    points = [point for foot in tree.points for point in foot]
    low = np.array([data.site(each.name).xpos[2] - each.radius for each in points])
    data.qpos[root.height] = -low.min()
    height = float(-low.min())
    feet = [tree.body_names[leg.foot[0]] for leg in tree.legs]
    return Stance(
        data.qpos.astype(np.float32),
        low - low.min() < 0.005 * height,
        np.array([data.body(foot).xpos[0] for foot in feet], np.float32),
        np.array([data.body(foot).xpos[2] + height for foot in feet], np.float32),
        height,
        GRAVITY * float(model.body_subtreemass[0]),
    )


@functools.cache
def anatomy(text: str, acting: str = "target", gains: str = "derived") -> Anatomy:
    """Returns the anatomy of a body.

    Args:
      text: its MJCF.
      acting: what the numbers of a policy are: "target" of joints, or "torque".
      gains: by which motors hold targets: "derived" from weight and size, or those of the "file".

    Raises:
      ValueError: the engines cannot move it, or nothing here can drive it.
    """
    tree = file_tree.of_text(text)
    root = PLANAR_ROOT if tree.planar else SPATIAL_ROOT
    coordinates = _coordinates(tree, stance(text), root)
    model = tree.hinged.mujoco
    points = tuple(
        ContactPoint(
            point.name,
            tree.body_names[point.body],
            leg.side,
            tuple(float(value) for value in model.site(point.name).pos),  # type: ignore[arg-type]
            point.radius,
        )
        for leg, foot in zip(tree.legs, tree.points, strict=True)
        for point in foot
    )
    return Anatomy(
        name=str(model.names[: model.names.index(b"\0")].decode()),
        coordinates=coordinates,
        joint_coordinate=tuple(range(len(coordinates))),
        root=root,
        torso=tree.body_names[1],
        motors=_motors(tree, stance(text), coordinates, acting, gains),
        points=points,
        legs=_legs(tree, stance(text), root.num, points),
        senses=_senses(tree, coordinates, root),
    )


def _coordinates(tree: FileTree, stance: Stance, root: Root) -> tuple[Coordinate, ...]:
    """Returns the coordinates with their mirror partners."""
    model = tree.hinged.mujoco
    data = mujoco.MjData(model)
    data.qpos[root.num :] = stance.qpos[root.num :]
    mujoco.mj_kinematics(model, data)
    partners = _partners(tree)
    found: list[Coordinate] = []
    for joint in range(model.njnt):
        kind = KINDS[int(model.jnt_type[joint])]
        mirror = joint if joint < root.num else root.num + partners[joint - root.num]
        # An axis of turning is mirrored the other way round.
        alike = float(data.xaxis[mirror] @ MIRROR @ data.xaxis[joint])
        sign = (1.0 if alike >= 0.0 else -1.0) * (1.0 if kind == "slide" else -1.0)
        limited = bool(model.jnt_limited[joint])
        lower, upper = model.jnt_range[joint] if limited else (-np.inf, np.inf)
        name = str(model.joint(joint).name)
        side = "middle" if mirror == joint else side_of(name)
        found.append(Coordinate(name, kind, side, mirror, sign, float(lower), float(upper)))
    return tuple(found)


def _partners(tree: FileTree) -> list[int]:
    """Returns the place of each joint's partner on the other side; its own of a middle one."""
    names = [each.name for each in tree.joints]
    partners = list(range(len(names)))
    for left, right in zip(tree.legs[::2], tree.legs[1::2], strict=False):
        pair = (left.side, right.side) == ("left", "right")
        if not pair or len(left.joints) != len(right.joints):
            continue
        ours, theirs = (
            [place for place, each in enumerate(tree.joints) if each.joint in leg.joints]
            for leg in (left, right)
        )
        for one, other in zip(ours, theirs, strict=True):
            partners[one], partners[other] = other, one
    bare = [(without_side(name).lower(), side_of(name)) for name in names]
    for place, (name, side) in enumerate(bare):
        other = (name, "right" if side == "left" else "left")
        if partners[place] == place and side != "middle" and other in bare:
            partners[place] = bare.index(other)
    return partners


def _legs(
    tree: FileTree, stance: Stance, first: int, points: tuple[ContactPoint, ...]
) -> tuple[Leg, ...]:
    """Returns the legs; hip, knee and ankle are their hinges that bend forward and backward."""
    data = mujoco.MjData(tree.hinged.mujoco)
    data.qpos[:] = stance.qpos
    mujoco.mj_kinematics(tree.hinged.mujoco, data)
    touching = {point.body for point in points}
    found: list[Leg] = []
    for leg in tree.legs:
        bending = [first + place for place, _ in bending_of(tree, stance, leg)]
        hip, knee, ankle = ([*bending, None, None, None])[:3]
        if len(bending) > 3:  # the foot's own is the ankle
            ankle = bending[-1]
        foot, *others = (tree.body_names[body] for body in leg.foot)
        feet = (foot, *(each for each in others if each in touching))
        x, y, z = (float(each) for each in data.body(foot).xmat.reshape(3, 3)[0])
        found.append(Leg(leg.side, foot, hip, knee, ankle, feet, (x, y, z)))
    return tuple(found)


def bending_of(tree: FileTree, stance: Stance, leg: Any) -> list[tuple[int, float]]:
    """Returns the joints of a leg that bend it forward and backward, from the hip down.

    They are places in `FileTree.joints`, each with the sign of the angle that moves what is below
    the joint backward: a human knee's flexion.
    """
    model = tree.hinged.mujoco
    data = mujoco.MjData(model)
    first = model.njnt - len(tree.joints)
    data.qpos[first:] = stance.qpos[first:]
    mujoco.mj_kinematics(model, data)
    return [
        (place, float(np.sign(data.xaxis[first + place][1])))
        for place, each in enumerate(tree.joints)
        if each.joint in leg.joints
        and KINDS[int(model.jnt_type[first + place])] == "hinge"
        and abs(data.xaxis[first + place][1]) > ACROSS
    ]


def _motors(
    tree: FileTree, stance: Stance, coordinates: tuple[Coordinate, ...], acting: str, gains: str
) -> tuple[Motor, ...]:
    first = len(coordinates) - len(tree.joints)
    usual = stance.weight * stance.height
    found: list[Motor] = []
    for each in mjcf_motors.of_tree(tree):
        place = first + each.joint
        weaker, stronger = sorted((abs(each.lowest), abs(each.highest)))
        strongest = weaker or stronger  # some, as a cable, pull to one side alone
        stiffness, damping = each.stiffness, each.damping
        if gains == "derived" or not stiffness:
            stiffness, damping = mjcf_motors.usual_gains(strongest, usual, stance.time)
        name = coordinates[place].name
        if acting == "target":
            law, strength, centre = "position", 1.0, float(stance.qpos[place])
        else:
            law, centre = "torque", 0.0
            strength = strongest if np.isfinite(strongest) else mjcf_motors.STRENGTH * usual
            stiffness, damping = 0.0, damping
        found.append(
            Motor(place, name, law, each.lowest, each.highest, strength, centre, damping, stiffness)
        )
    return tuple(found)


def _senses(tree: FileTree, coordinates: tuple[Coordinate, ...], root: Root) -> tuple[Sense, ...]:
    joints = tuple(each.name for each in coordinates[root.num :])
    legs = tuple(f"{place} {leg.side}" for place, leg in enumerate(tree.legs))
    axes = ("x", "z") if root.is_planar else ("x", "y", "z")
    turns = ("y",) if root.is_planar else ("x", "y", "z")
    heading = () if root.is_planar else ("yaw",)
    return (
        Sense("time", "s", "since the start of the trial"),
        Sense("up", "", "the world's vertical in the torso's axes", axes),
        Sense("turning", "rad/s", "angular velocity of the torso in its axes", turns),
        Sense("velocity", "m/s", "of the torso's origin in its axes", axes),
        Sense("heading", "rad", "how far the torso is turned to the left", heading),
        Sense("angle", "rad", "of each joint", joints),
        Sense("rate", "rad/s", "of each joint", joints),
        Sense("contact", "", "whether each foot touches the ground", legs),
        Sense("ankle_x", "m", "how far each foot's origin is ahead of the torso's", legs),
    )
