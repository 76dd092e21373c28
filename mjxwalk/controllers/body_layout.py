"""What a policy sees and moves of a body: its anatomy as a `Layout`."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.controllers.layout import Layout
from mjxwalk.envs import targets
from mjxwalk.envs.checks import MOST_STEPS

# ours: what brings senses to about -1 ... 1, in radians, and in lengths and times of the body.
ROTATION, RATE = 5.0, 10.0  # rad/s of a body of 1 m and its time
# Parts of senses that change their sign as left and right change places.
FLIPPED = {
    "up": {"y"},
    "turning": {"x", "z"},
    "velocity": {"y"},
    "heading": {"yaw"},
    "torso": {"yaw", "roll"},
    "torso_rate": {"yaw", "roll"},
}
# How far each joint moves what is below it backward as its leg is lifted.
LIFT = {"hip": -0.35, "knee": 0.7, "ankle": -0.35}  # rad; ours: the foot stays level
JOINT_SENSES = {"angle": True, "rate": False, "adduction": True, "adduction_rate": False}
OTHER_SIDE = {"left": "right", "right": "left"}


class _Body(NamedTuple):
    """What there is to know of a body beside its anatomy.

    Attributes:
      rest: of each coordinate as trials start, the same on both sides.
      height: of the root or of the legs, m.
      time: that a fall from there needs, over the square root of two, s.
      sees: places of the coordinates whose angles are seen.
      motors: places of the motors that are moved.
      lift: of each of them, how far it moves as its leg is lifted.
    """

    rest: Float[np.ndarray, " coordinate"]
    height: float
    time: float
    sees: set[int]
    motors: list[int]
    lift: tuple[float, ...]


class _Input(NamedTuple):
    name: str
    place: int
    centre: float
    scale: float
    mirror: str
    sign: float


def of_body(env: Any, *, moved: str, rates: bool, period: float) -> Layout:
    """Returns the layout of an environment with an anatomy.

    Args:
      env: an environment of a body, as every `LeggedEnv` is.
      moved: of a body of a file, "legs" for the motors of its legs, which then are all that is
        read of its joints, or "all".
      rates: whether the rates of joints are read.
      period: from one action to the next, s.

    Raises:
      ValueError: the period is longer than a trial can be.
    """
    longest = MOST_STEPS * env.timestep
    if period > longest:
        raise ValueError(
            f"period must be at most {longest:g} s, {MOST_STEPS:,} steps of the physics, got "
            f"{period:g}"
        )
    anatomy = env.anatomy
    body = _of_file(env, moved) if hasattr(env, "stance") else _of_anatomy(env)
    inputs = _inputs(anatomy, body, rates)
    names = [each.name for each in inputs]
    coordinates = [anatomy.motors[place].coordinate for place in body.motors]
    partners = [anatomy.coordinates[each].mirror for each in coordinates]
    return Layout(
        inputs=tuple(names),
        places=tuple(each.place for each in inputs),
        centre=tuple(float(each.centre) for each in inputs),
        scale=tuple(float(each.scale) for each in inputs),
        input_mirror=tuple(names.index(each.mirror) for each in inputs),
        input_sign=tuple(float(each.sign) for each in inputs),
        outputs=tuple(anatomy.motors[place].name for place in body.motors),
        motors=tuple(body.motors),
        output_mirror=tuple(coordinates.index(each) for each in partners),
        output_sign=tuple(anatomy.coordinates[each].sign for each in coordinates),
        num_motors=len(anatomy.motors),
        lift=body.lift,
        time=body.time,
        every=max(1, round(period / env.timestep)),
    )


def _of_file(env: Any, moved: str) -> _Body:
    """Returns a body that is given by its file."""
    from mjxwalk.envs.derived import anatomy as mjcf_anatomy
    from mjxwalk.envs.derived import file_tree

    anatomy, tree = env.anatomy, file_tree.of_text(env.body)
    stance, root = mjcf_anatomy.stance(env.body), anatomy.root
    of_legs = {
        root.num + place
        for place, joint in enumerate(tree.joints)
        for leg in tree.legs
        if joint.joint in leg.joints
    }
    motors = [
        place
        for place, motor in enumerate(anatomy.motors)
        if moved == "all" or motor.coordinate in of_legs
    ]
    coordinates = [anatomy.motors[place].coordinate for place in motors]
    return _Body(
        rest=stance.qpos,
        height=stance.height,
        time=float(stance.time),
        sees=set(coordinates),
        motors=motors,
        lift=_lift(anatomy, tree, stance, coordinates),
    )


def _of_anatomy(env: Any) -> _Body:
    """Returns one of our own bodies, all of whose joints are of legs."""
    anatomy = env.anatomy
    lift: dict[int | None, float] = {}
    if env.acting == "target":  # flexion and dorsiflexion are positive
        for leg in anatomy.legs:
            lift |= {leg.hip: -LIFT["hip"], leg.knee: LIFT["knee"], leg.ankle: -LIFT["ankle"]}
    return _Body(
        rest=targets.rest(env),
        height=float(env.leg_length),
        time=float(env.walking_time),
        sees=set(range(anatomy.root.num, len(anatomy.coordinates))),
        motors=list(range(len(anatomy.motors))),
        lift=tuple(lift.get(motor.coordinate, 0.0) for motor in anatomy.motors),
    )


def _inputs(anatomy: Any, body: _Body, rates: bool) -> list[_Input]:
    """Returns each sense that is read."""
    found: list[_Input] = []
    place = 0
    pace = body.height / body.time
    spin = ROTATION * 0.3 / body.time
    scales = {"up": 0.5, "turning": spin, "velocity": 0.3 * pace, "heading": 0.5}
    # ours, of our own bodies: a torso that leans by half a radian falls.
    scales |= {"pitch": 0.5, "torso": 0.5, "pitch_rate": spin, "torso_rate": spin}
    for sense in anatomy.senses:
        nothing = sense.name == "heading" and anatomy.root.is_planar
        for part in sense.order or (() if nothing else ("",)):
            name = f"{sense.name} {part}".strip()
            if sense.name in scales:
                sign = -1.0 if part in FLIPPED.get(sense.name, ()) else 1.0
                # All but the vertical's own part, which says nothing that the others do not.
                if not (sense.name, part) == ("up", "z"):
                    found.append(_Input(name, place, 0.0, scales[sense.name], name, sign))
            elif sense.name == "contact" and part in OTHER_SIDE:
                other = f"{sense.name} {OTHER_SIDE[part]}"
                found.append(_Input(name, place, 0.5, 0.5, other, 1.0))
            elif sense.name in JOINT_SENSES:
                joint = part or "adduction"
                is_angle = JOINT_SENSES[sense.name]
                at = anatomy.names.index(joint)
                coordinate = anatomy.coordinates[at]
                if at in body.sees and (is_angle or rates):
                    other = anatomy.names[coordinate.mirror] if part else ""
                    still = float(body.rest[at]) if is_angle else 0.0
                    scale = 1.0 if is_angle else RATE * 0.3 / body.time
                    mirror = f"{sense.name} {other}".strip()
                    found.append(_Input(name, place, still, scale, mirror, coordinate.sign))
            place += 1
    return found


def _lift(anatomy: Any, tree: Any, stance: Any, coordinates: list[int]) -> tuple[float, ...]:
    """Returns how far each joint bends as its leg is lifted, in units of an action of 1."""
    from mjxwalk.envs.derived import anatomy as mjcf_anatomy

    lift = dict.fromkeys(coordinates, 0.0)
    for leg, place in zip(tree.legs, anatomy.legs, strict=True):
        signs = dict(mjcf_anatomy.bending_of(tree, stance, leg))
        for role, share in LIFT.items():
            coordinate = getattr(place, role)
            if coordinate in lift:
                lift[coordinate] = share * signs[coordinate - anatomy.root.num]
    return tuple(lift.values())
