"""What a controller asks of a body's motors, and what they give."""

from typing import NamedTuple

from jaxtyping import Array, Float


class Action(NamedTuple):
    """Each motor gives torque + stiffness (target - angle) - damping rate.

    Attributes:
      torque: N m.
      target: rad.
      stiffness: N m/rad.
      damping: N m s/rad.
    """

    torque: Float[Array, " joint"]
    target: Float[Array, " joint"]
    stiffness: Float[Array, " joint"]
    damping: Float[Array, " joint"]


def torque(
    action: Action, angle: Float[Array, " joint"], rate: Float[Array, " joint"], *, ahead: float
) -> Float[Array, " joint"]:
    """Returns the motors' torque, N m, with angles moved on by `ahead` seconds at the given rates.

    Taken linearly implicit over a step, that is the torque at its end: with the rates at the step's
    end the whole of it, with those at its start the part that is known; `added_inertia` stands for
    the other part.
    """
    off_target = action.target - angle - ahead * rate
    return action.torque + action.stiffness * off_target - action.damping * rate


def added_inertia(action: Action, timestep: float) -> Float[Array, " joint"]:
    """Returns what of implicit motors belongs on the mass matrix's diagonal, kg m^2."""
    return timestep * (action.damping + timestep * action.stiffness)
