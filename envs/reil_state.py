"""What the biped of Reil & Massey is asked, what it senses, and what it is between two steps.

Source as in `reil.py`.
"""

from typing import NamedTuple

from jaxtyping import Array, Bool, Float, Int


class HipTargets(NamedTuple):
    """What a controller asks of the motors.

    Attributes:
      angle: desired pitch of the left and the right hip, rad, forward positive.
    """

    angle: Float[Array, "2"]


class Observation(NamedTuple):
    """What the walker senses; legs in the order left, right.

    Attributes:
      time: since the start, s.
      torso: yaw, pitch and roll of the trunk, rad: turning left, leaning forward and right are
        positive.
      torso_rate: of the same, rad/s.
      angle: hip roll, hip, knee and ankle of each leg, rad.
      rate: of the same, rad/s.
      contact: whether the foot touches the ground.
      ankle_x: how far each ankle is ahead of the hips, m.
    """

    time: Float[Array, ""]
    torso: Float[Array, "3"]
    torso_rate: Float[Array, "3"]
    angle: Float[Array, "2 4"]
    rate: Float[Array, "2 4"]
    contact: Bool[Array, "2"]
    ankle_x: Float[Array, "2"]


class State(NamedTuple):
    """One walker between two steps; contacts and ankles are those that the last step saw.

    Attributes:
      qpos: the coordinates: the hips' midpoint x, y and z (m), yaw, pitch and roll of the trunk,
        joints (rad).
      qvel: m/s and rad/s.
      stretch: of the ground's tangential springs along x and y, m; heel and toe, left, then right.
      touching: whether those spheres touch the ground.
      ankle_x: how far each ankle is ahead of the hips, m.
      height: of the centre of mass over the ground, m.
      target: last desired angles of the hips, rad.
      still_time: since one of them last changed, s.
      num_steps: physics steps so far.
      flight_time: since a foot last touched the ground, s.
      torque_cost: integral of the motors' summed absolute torque, N m s.
      work: integral of the motors' summed absolute power, J.
      fell: whether the trial ended by a fall, or by physics that diverged.
      diverged: whether the physics diverged; the rest is then the last sound state.
      done: whether the trial has ended.
    """

    qpos: Float[Array, "14"]
    qvel: Float[Array, "14"]
    stretch: Float[Array, "4 2"]
    touching: Bool[Array, "4"]
    ankle_x: Float[Array, "2"]
    height: Float[Array, ""]
    target: Float[Array, "2"]
    still_time: Float[Array, ""]
    num_steps: Int[Array, ""]
    flight_time: Float[Array, ""]
    torque_cost: Float[Array, ""]
    work: Float[Array, ""]
    fell: Bool[Array, ""]
    diverged: Bool[Array, ""]
    done: Bool[Array, ""]
