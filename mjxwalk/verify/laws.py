"""The laws of ground, joint stops and motors once more, in float64 numpy for several walkers.

Written from docs/physics.md and docs/reil.md, not from `mjxwalk.envs`, so that a slip in one of the
two shows.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from mjxwalk.envs import (
    Action,
    Anatomy,
    Course,
    JointStop,
    RandomWalk,
    SerpentineWalk,
    SoftContact,
    TrialVariation,
    VelocityMotor,
)

FULL_FRICTION = 0.1  # rad/s; docs/physics.md
CLOSE = 1e-13  # of a motor's limit; where torques that are solved for have settled


class GroundForce(NamedTuple):
    """What the ground does to the points of the feet.

    Attributes:
      force: world axes, N.
      mass: of the points, kg; stands for the part that depends on the unknown accelerations.
      stretch: of the tangential springs after slipping, m.
      touching: which points are below the ground.
    """

    force: Float[np.ndarray, "walker point 3"]
    mass: Float[np.ndarray, "walker point"]
    stretch: Float[np.ndarray, "walker point tangent"]
    touching: Bool[np.ndarray, "walker point"]


class Lying(NamedTuple):
    """What lies on the random ground at some points; nothing by default.

    Attributes:
      height: m.
      gradient: m upwards for each m along x.
      stiffness: factor of spring and damper.
      friction: factor of the coefficient of friction.
    """

    height: Any = 0.0
    gradient: Any = 0.0
    stiffness: Any = 1.0
    friction: Any = 1.0


def ground_force(
    law: SoftContact,
    depth: Float[np.ndarray, "walker point"],
    velocity: Float[np.ndarray, "walker point 3"],
    stretch: Float[np.ndarray, "walker point tangent"],
    *,
    timestep: float,
    implicit: bool,
    course: Lying,
) -> GroundForce:
    """Returns spring, damper and friction at each point; tangents are x, and y where there are two.

    Args:
      law: of the ground.
      depth: below the ground, m.
      velocity: world axes, m/s.
      stretch: of the springs before the step, m.
      timestep: s.
      implicit: whether the law is taken at the end of the step.
      course: what of it lies under the points.
    """
    tangents = stretch.shape[-1]
    angle = np.arctan(course.gradient)
    sine, cosine = np.sin(angle), np.cos(angle)
    depth, velocity = depth * cosine, _turned(velocity, sine, cosine)
    stiffness = law.stiffness * course.stiffness
    damping = law.damping * course.stiffness + (stiffness * timestep if implicit else 0.0)
    touching = depth > 0.0
    normal = np.maximum(0.0, stiffness * depth - damping * velocity[..., 2]) * touching
    stretch = (stretch + timestep * velocity[..., :tangents]) * touching[..., None]
    limit = law.friction * course.friction * normal
    sticking = -_each(stiffness) * stretch - _each(damping) * velocity[..., :tangents]
    force = np.zeros_like(velocity)
    force[..., :tangents] = shortened(sticking, limit)
    force[..., 2] = normal
    mass = np.where(normal > 0.0, timestep * damping if implicit else 0.0, 0.0)
    stretch = shortened(stretch, limit / stiffness)
    return GroundForce(_turned(force, -sine, cosine), mass, stretch, touching)


def _each(values: Any) -> Any:
    """Returns numbers of points as those of their vectors."""
    return np.asarray(values)[..., None]


def _turned(vectors: Any, sine: Any, cosine: Any) -> Any:
    """Returns vectors in axes that are turned about y, so that x goes up by such an angle."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack([cosine * x + sine * z, y, cosine * z - sine * x], axis=-1)


def stop_torque(
    law: JointStop,
    angle: Float[np.ndarray, "walker joint"],
    rate: Float[np.ndarray, "walker joint"],
    limits: Float[np.ndarray, "joint 2"],
    *,
    timestep: float,
    implicit: bool,
) -> tuple[Float[np.ndarray, "walker joint"], Float[np.ndarray, "walker joint"]]:
    """Returns the torque of the joint stops, N m, and the inertia of its implicit part, kg m^2."""
    damping = law.damping + (law.stiffness * timestep if implicit else 0.0)
    inwards = np.clip(angle, limits[:, 0], limits[:, 1]) - angle
    push = law.stiffness * inwards - damping * rate
    acts = push * inwards > 0.0
    return push * acts, acts * (timestep * damping if implicit else 0.0)


def friction_damping(
    most: Float[np.ndarray, " joint"], rate: Float[np.ndarray, "walker joint"]
) -> Float[np.ndarray, "walker joint"]:
    """Returns the damping, N m s/rad, that is a joint's friction at its rate, N m.

    All of the friction acts from `FULL_FRICTION` on.
    """
    fast = np.abs(rate) > FULL_FRICTION
    return most / np.where(fast, np.abs(rate), FULL_FRICTION)


def motor_torque(action: Action, angle: Any, rate: Any, ahead: float) -> Any:
    """Returns what is asked of motors, N m, with angles moved on by so many seconds."""
    off_target = np.asarray(action.target) - angle - ahead * rate
    spring = np.asarray(action.stiffness) * off_target
    return np.asarray(action.torque) + spring - np.asarray(action.damping) * rate


def of_numbers(
    anatomy: Anatomy, numbers: Float[np.ndarray, "walker motor"]
) -> tuple[Float[np.ndarray, "walker motor"], ...]:
    """Returns what numbers from -1 to 1 ask of motors, as the anatomy says, field by field."""
    moves = np.clip(numbers, -1.0, 1.0)

    def each(field: str) -> Any:
        values = [getattr(motor, field) for motor in anatomy.motors]
        return np.broadcast_to(np.array(values, np.float64), moves.shape)

    nothing = np.zeros(moves.shape)
    match anatomy.motors[0].law:
        case "torque":
            return each("strength") * moves, nothing, nothing, each("damping")
        case "velocity":
            return (each("centre") + each("strength") * moves,)
        case "position":
            ends = [anatomy.coordinates[motor.coordinate] for motor in anatomy.motors]
            target = each("centre") + each("strength") * moves
            target = np.maximum(target, [end.lower for end in ends])
            target = np.minimum(target, [end.upper for end in ends])
            return nothing, target, each("stiffness"), each("damping")


def velocity_torque(
    law: VelocityMotor,
    wanted: Float[np.ndarray, "walker motor"],
    answer: Float[np.ndarray, "walker motor motor"],
    limits: Float[np.ndarray, "motor 2"],
) -> Float[np.ndarray, "walker motor"]:
    """Returns torques, N m, that change velocities as wanted, as far as their limits let them.

    They are the minimum of x A x / 2 - x b within the limits, found by going down along one torque
    after the other until none moves.

    Args:
      law: of the motors.
      wanted: change of velocity that motors are to bring, rad/s.
      answer: change of velocity that each torque brings, rad/s/(N m).
      limits: least and greatest torques, N m.
    """
    matrix = answer + law.softness * np.eye(len(limits))
    torque = np.clip(np.linalg.solve(matrix, wanted[..., None])[..., 0], *limits.T)
    moved = np.inf
    while moved > CLOSE * np.abs(limits).max():
        before = torque.copy()
        for motor, (least, most) in enumerate(limits):
            missing = wanted[:, motor] - (matrix[:, motor] * torque).sum(axis=1)
            own = torque[:, motor] + missing / matrix[:, motor, motor]
            torque[:, motor] = np.clip(own, least, most)
        moved = np.abs(torque - before).max()
    return torque


def requested(law: VelocityMotor, off_target: Any) -> Any:
    """Returns the velocity at which motors go to angles that are so far off, rad/s."""
    return np.clip(law.approach * off_target, -law.max_speed, law.max_speed)


def shortened(
    vector: Float[np.ndarray, "*batch tangent"], limit: Float[np.ndarray, "*batch"]
) -> Float[np.ndarray, "*batch tangent"]:
    """Returns the vectors, none longer than its limit."""
    length = np.sqrt(np.sum(vector * vector, axis=-1))
    over = length > limit
    return vector * np.where(over, limit / np.where(over, length, 1.0), 1.0)[..., None]


def height(
    shape: Any,
    heights: Float[np.ndarray, " walker *node"],
    x: Float[np.ndarray, " walker *point"],
    y: Float[np.ndarray, " walker *point"],
) -> Float[np.ndarray, " walker *point"]:
    """Returns the ground's height under points, m.

    Args:
      shape: of the ground; `GROUNDS` has those that are known.
      heights: of each walker's own nodes, m.
      x: of the points, m.
      y: of the points, m; the ground in the plane does not know it.
    """
    walker = np.arange(len(x)).reshape(-1, *[1] * (x.ndim - 1))
    return GROUNDS[type(shape)](shape, heights, walker, x, y)


def lying(
    settings: Course,
    course: Float[np.ndarray, "walker node channel"] | None,
    x: Float[np.ndarray, " walker *point"],
) -> Lying:
    """Returns what of the walkers' courses lies at such x, m.

    Args:
      settings: of the courses.
      course: of each walker; None where nothing lies along the way.
      x: of the points, m.
    """
    if course is None:
        return Lying()
    walker = np.arange(len(x)).reshape(-1, *[1] * (x.ndim - 1))
    nodes, position = course.shape[1], x / settings.spacing
    node, onward = _interval(position, nodes)
    before, after = course[walker, node], course[walker, node + 1]
    found = (1 - onward[..., None]) * before + onward[..., None] * after
    beyond = (position <= 0.0) | (position >= nodes - 1)
    rising = np.where(beyond, 0.0, after[..., 0] - before[..., 0]) / settings.spacing
    soil = (found[..., 1], found[..., 2]) if course.shape[2] == 3 else (1.0, 1.0)
    return Lying(found[..., 0], rising if settings.has_relief else 0.0, *soil)


def _on_line(shape: RandomWalk, heights: Any, walker: Any, x: Any, y: Any) -> Any:
    del y
    row, onward = _interval((x - shape.start) / shape.spacing, heights.shape[1])
    return (1 - onward) * heights[walker, row] + onward * heights[walker, row + 1]


def _on_grid(shape: SerpentineWalk, heights: Any, walker: Any, x: Any, y: Any) -> Any:
    row, onward = _interval((x - shape.start) / shape.spacing, heights.shape[1])
    last = heights.shape[2] - 1
    # To the sides the ground goes on as its mirror image.
    sideways = np.mod(y / shape.spacing + 0.5 * last, 2 * last)
    column, across = _interval(np.minimum(sideways, 2 * last - sideways), heights.shape[2])
    near, far = (
        (1 - across) * heights[walker, along, column] + across * heights[walker, along, column + 1]
        for along in (row, row + 1)
    )
    return (1 - onward) * near + onward * far


def _on_slope(shape: TrialVariation, heights: Any, walker: Any, x: Any, y: Any) -> Any:
    del shape, y
    return x * heights[walker, 0]


GROUNDS: Mapping[type, Callable[..., Any]] = {
    RandomWalk: _on_line,
    SerpentineWalk: _on_grid,
    TrialVariation: _on_slope,
}


def _interval(position: Any, nodes: int) -> tuple[Any, Any]:
    """Returns the node before a position, and how far on to the next it is; ends go on level."""
    # As `maximum` passes NaN on and `fmax` does not: that becomes node 0.
    inside = np.fmin(np.fmax(position, 0.0), nodes - 1.0)
    before = np.minimum(inside.astype(int), nodes - 2)
    return before, inside - before
