"""What walkers sense, by name; the anatomy's senses give units and order."""

from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from mjxwalk.envs import floating
from mjxwalk.envs.anatomy import Root
from mjxwalk.envs.state import State


class BodyObservation(NamedTuple):
    """What a walker of any body senses; see the senses of its anatomy for the order.

    Attributes:
      time: since the start, s.
      up: the vertical of the world in the axes of the torso; x and z in the plane.
      turning: angular velocity of the torso in its axes, rad/s; about y alone in the plane.
      velocity: of the origin of the torso in its axes, m/s; x and z in the plane.
      heading: how far the torso is turned to the left, rad; nothing in the plane.
      angle: of each joint, rad.
      rate: of each joint, rad/s.
      contact: whether each foot touches the ground.
      ankle_x: how far the origin of each foot is ahead of that of the torso, m.
    """

    time: Float[Array, ""]
    up: Float[Array, " axis"]
    turning: Float[Array, " turn"]
    velocity: Float[Array, " axis"]
    heading: Float[Array, " heading"]
    angle: Float[Array, " joint"]
    rate: Float[Array, " joint"]
    contact: Bool[Array, " leg"]
    ankle_x: Float[Array, " leg"]


def of_body(
    state: State, root: Root, *, contact: Bool[Array, " leg"], time: Any
) -> BodyObservation:
    """Returns what a walker of any body senses.

    Args:
      state: of the walker.
      root: of its body.
      contact: whether each foot touches the ground.
      time: since the start, s.
    """
    if root.is_planar:
        pitch = state.qpos[root.pitch]
        sine, cosine = jnp.sin(pitch), jnp.cos(pitch)
        x, z = state.qvel[:2]
        up = jnp.stack([-sine, cosine])
        turning = state.qvel[root.pitch : root.num]
        velocity = jnp.stack([cosine * x - sine * z, sine * x + cosine * z])
        heading = jnp.zeros(0)
    else:
        axes = floating.rotation(state.qpos[3:6])
        up, velocity = axes[2], state.qvel[:3] @ axes
        turning = floating.spin(state.qpos[3:6], state.qvel[3:6])
        heading = state.qpos[3:4]
    return BodyObservation(
        time=time,
        up=up,
        turning=turning,
        velocity=velocity,
        heading=heading,
        angle=state.qpos[root.num :],
        rate=state.qvel[root.num :],
        contact=contact,
        ankle_x=state.ankle_x,
    )


class PlanarObservation(NamedTuple):
    """What a walker in the plane senses; legs in the order left, right.

    Attributes:
      time: since the start, s.
      pitch: of the upper body, rad, forward lean positive.
      pitch_rate: rad/s.
      angle: of each leg's joints, rad.
      rate: their rates, rad/s.
      contact: whether the foot touches the ground.
      ankle_x: how far each ankle is ahead of the hip, m.
    """

    time: Float[Array, ""]
    pitch: Float[Array, ""]
    pitch_rate: Float[Array, ""]
    angle: Float[Array, "2 joint"]
    rate: Float[Array, "2 joint"]
    contact: Bool[Array, "2"]
    ankle_x: Float[Array, "2"]


class SpatialObservation(NamedTuple):
    """What a walker in space senses; legs in the order left, right.

    Attributes:
      time: since the start, s.
      torso: its yaw, pitch and roll, rad: turning left, leaning forward and right are positive.
      torso_rate: their rates, rad/s.
      adduction: angle of both legs to the torso, rad, legs apart positive; None of bodies whose
        legs do not share it.
      adduction_rate: rad/s.
      angle: of each leg's joints, rad.
      rate: their rates, rad/s.
      contact: whether the foot touches the ground.
      ankle_x: how far each ankle is ahead of the hips, m.
    """

    time: Float[Array, ""]
    torso: Float[Array, "3"]
    torso_rate: Float[Array, "3"]
    adduction: Float[Array, ""] | None
    adduction_rate: Float[Array, ""] | None
    angle: Float[Array, "2 joint"]
    rate: Float[Array, "2 joint"]
    contact: Bool[Array, "2"]
    ankle_x: Float[Array, "2"]
