"""What walkers sense, by name; the anatomy's senses give units and order."""

from typing import NamedTuple

from jaxtyping import Array, Bool, Float


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
