"""The laws of ground and joint stops once more, in float64 numpy for several walkers at once.

Written from docs/physics.md, not from `mjxwalk.envs`, so that a slip in one of the two shows.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from mjxwalk.envs import JointStop, RandomWalk, SerpentineWalk, SoftContact


class Push(NamedTuple):
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


def ground_push(
    law: SoftContact,
    depth: Float[np.ndarray, "walker point"],
    velocity: Float[np.ndarray, "walker point 3"],
    stretch: Float[np.ndarray, "walker point tangent"],
    *,
    timestep: float,
    implicit: bool,
) -> Push:
    """Returns spring, damper and friction at each point; tangents are x, and y where there are two.

    Args:
      law: of the ground.
      depth: below the ground, m.
      velocity: world axes, m/s.
      stretch: of the springs before the step, m.
      timestep: s.
      implicit: whether the law is taken at the end of the step.
    """
    tangents = stretch.shape[-1]
    damping = law.damping + (law.stiffness * timestep if implicit else 0.0)
    touching = depth > 0.0
    normal = np.maximum(0.0, law.stiffness * depth - damping * velocity[..., 2]) * touching
    stretch = (stretch + timestep * velocity[..., :tangents]) * touching[..., None]
    limit = law.friction * normal
    sticking = -law.stiffness * stretch - damping * velocity[..., :tangents]
    force = np.zeros_like(velocity)
    force[..., :tangents] = shortened(sticking, limit)
    force[..., 2] = normal
    mass = np.where(normal > 0.0, timestep * damping if implicit else 0.0, 0.0)
    return Push(force, mass, shortened(stretch, limit / law.stiffness), touching)


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


def shortened(
    vector: Float[np.ndarray, "*batch tangent"], limit: Float[np.ndarray, "*batch"]
) -> Float[np.ndarray, "*batch tangent"]:
    """Returns the vectors, none longer than its limit."""
    length = np.sqrt(np.sum(vector * vector, axis=-1))
    over = length > limit
    return vector * np.where(over, limit / np.where(over, length, 1.0), 1.0)[..., None]


def height(
    shape: RandomWalk | SerpentineWalk,
    heights: Float[np.ndarray, " walker *node"],
    x: Float[np.ndarray, " walker *point"],
    y: Float[np.ndarray, " walker *point"],
) -> Float[np.ndarray, " walker *point"]:
    """Returns the ground's height under points, m.

    Args:
      shape: of the ground.
      heights: of each walker's own nodes, m.
      x: of the points, m.
      y: likewise; the ground in the plane does not know it.
    """
    walker = np.arange(len(x)).reshape(-1, *[1] * (x.ndim - 1))
    row, onward = _interval((x - shape.start) / shape.spacing, heights.shape[1])
    if isinstance(shape, RandomWalk):
        return (1 - onward) * heights[walker, row] + onward * heights[walker, row + 1]
    last = heights.shape[2] - 1
    # To the sides the ground goes on as its mirror image.
    sideways = np.mod(y / shape.spacing + 0.5 * last, 2 * last)
    column, across = _interval(np.minimum(sideways, 2 * last - sideways), heights.shape[2])
    near, far = (
        (1 - across) * heights[walker, along, column] + across * heights[walker, along, column + 1]
        for along in (row, row + 1)
    )
    return (1 - onward) * near + onward * far


def _interval(position: Any, nodes: int) -> tuple[Any, Any]:
    """Returns the node before a position, and how far on to the next it is; ends go on level."""
    # As `maximum` passes NaN on and `fmax` does not: that becomes node 0.
    inside = np.fmin(np.fmax(position, 0.0), nodes - 1.0)
    before = np.minimum(inside.astype(int), nodes - 2)
    return before, inside - before
