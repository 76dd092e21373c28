"""The anatomy of a body, from its compiled model and the few things that it does not say."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.envs.anatomy import (
    KINDS,
    LEGS,
    MIRROR,
    Anatomy,
    ContactPoint,
    Coordinate,
    Leg,
    Motor,
    Root,
    Sense,
    Side,
    side_of,
    without_side,
)


class Strength(NamedTuple):
    """What motors give for an action of 1, where a policy acts by numbers from -1 to 1."""

    law: Literal["torque", "velocity"]
    strength: Sequence[float]
    centre: float = 0.0
    damping: float = 0.0


def derive(
    model: Any,
    *,
    name: str,
    motors: Sequence[str],
    points: Sequence[str],
    senses: tuple[Sense, ...],
    strength: Strength,
    limits: Float[np.ndarray, "motor 2"] | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    tied: tuple[str, str] | None = None,
    radius: float = 0.0,
) -> Anatomy:
    """Returns the anatomy of a body with one tree, whose root has joints in the world's axes.

    Args:
      model: the `mujoco.MjModel`, with slides and hinges only.
      name: of the body.
      motors: coordinates with a motor, in the order of an action.
      points: sites that touch the ground, in the order of a state.
      senses: what is sensed.
      strength: of the motors for policies that act by numbers from -1 to 1.
      limits: least and greatest torque of each motor, N m; None for those of no limit.
      ranges: of joints, in place of the model's; None where the model has them.
      tied: two joints that one coordinate moves.
      radius: of a sphere about each point, m.
    """
    joints = [str(model.joint(joint).name) for joint in range(model.njnt)]
    coordinate_names = [without_side(each) if tied and each in tied else each for each in joints]
    names = list(dict.fromkeys(coordinate_names))
    first = [coordinate_names.index(each) for each in names]
    coordinates = [_coordinate(model, joints, names, first, place) for place in range(len(names))]
    for joint, (lower, upper) in (ranges or {}).items():
        place = names.index(joint)
        coordinates[place] = coordinates[place]._replace(lower=lower, upper=upper)
    found = [_point(model, each, radius) for each in points]
    most = np.full((len(motors), 2), (-np.inf, np.inf)) if limits is None else limits
    return Anatomy(
        name=name,
        coordinates=tuple(coordinates),
        joint_coordinate=tuple(names.index(each) for each in coordinate_names),
        root=_root(model, names),
        torso=str(model.body(1).name),
        motors=tuple(
            Motor(
                names.index(each),
                each,
                strength.law,
                float(low),
                float(high),
                float(one),
                strength.centre,
                strength.damping,
            )
            for each, (low, high), one in zip(motors, most, strength.strength, strict=True)
        ),
        points=tuple(found),
        legs=tuple(_leg(names, found, side) for side in LEGS),
        senses=senses,
    )


def _coordinate(
    model: Any, joints: list[str], names: list[str], first: list[int], place: int
) -> Coordinate:
    joint, name = first[place], names[place]
    kind, side = KINDS[int(model.jnt_type[joint])], side_of(name)
    partner = name
    if side != "middle":
        partner = f"{without_side(name)}_{'right' if side == 'left' else 'left'}"
    mirror = names.index(partner) if partner in names else place
    # Of a coordinate that moves a joint of either leg, the partner is the other joint.
    twin = joints[joint] if name in joints else joints[joint].replace("left", "right")
    other = joints.index(twin) if mirror == place else first[mirror]
    axis, mirrored = model.jnt_axis[other], MIRROR @ model.jnt_axis[joint]
    limited = bool(model.jnt_limited[joint])
    lower, upper = model.jnt_range[joint] if limited else (-np.inf, np.inf)
    # An axis of turning is mirrored the other way round.
    sign = float(np.sign(axis @ mirrored)) * (1.0 if kind == "slide" else -1.0)
    return Coordinate(name, kind, side, mirror, sign, float(lower), float(upper))


def _root(model: Any, names: list[str]) -> Root:
    """Returns the root's coordinates, by how the joints of the tree's first body are turned."""
    num = int(model.body_jntnum[1])
    found: dict[tuple[str, str], int] = {}
    for joint in range(num):
        axis = "xyz"[int(np.argmax(np.abs(model.jnt_axis[joint])))]
        found[KINDS[int(model.jnt_type[joint])], axis] = joint
    return Root(
        num=num,
        forward=found["slide", "x"],
        sideways=found.get(("slide", "y")),
        height=found["slide", "z"],
        yaw=found.get(("hinge", "z")),
        pitch=found["hinge", "y"],
        roll=found.get(("hinge", "x")),
    )


def _point(model: Any, name: str, radius: float) -> ContactPoint:
    site = model.site(name)
    body = str(model.body(int(model.site_bodyid[site.id])).name)
    x, y, z = (float(value) for value in site.pos)
    return ContactPoint(name, body, side_of(body), (x, y, z), radius)


def _leg(names: list[str], points: list[ContactPoint], side: Side) -> Leg:
    def place(role: str) -> int | None:
        return names.index(f"{role}_{side}") if f"{role}_{side}" in names else None

    foot = next(point.body for point in points if point.side == side)
    return Leg(side, foot, place("hip"), place("knee"), place("ankle"))
