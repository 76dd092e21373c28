"""What a controller asks of a body's motors, what they give, and what joints do by themselves."""

from typing import Literal, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from mjxwalk.envs.anatomy import Anatomy

# rad/s; ours: slower joints feel their friction as a damper, so that a joint at rest has none
FRICTION_RATE = 0.1


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


class Limits(NamedTuple):
    """What motors can give at least and at most, N m; infinite where they are not limited."""

    lowest: Float[np.ndarray, " joint"]
    highest: Float[np.ndarray, " joint"]


class Springs(NamedTuple):
    """Passive springs and dampers of joints.

    Attributes:
      stiffness: N m/rad.
      rest: angle without torque, rad.
      damping: N m s/rad.
    """

    stiffness: Float[np.ndarray, " joint"]
    rest: Float[np.ndarray, " joint"]
    damping: Float[np.ndarray, " joint"]


class Drive(NamedTuple):
    """What motors do in a step.

    Attributes:
      torque: that is known before the step, N m.
      added_inertia: stands for the implicit rest, kg m^2.
    """

    torque: Float[Array, " joint"]
    added_inertia: Float[Array, " joint"]


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


def driven(
    action: Action,
    angle: Float[Array, " joint"],
    rate: Float[Array, " joint"],
    limits: Limits | None,
    *,
    ahead: float,
) -> Drive:
    """Returns what motors do in a step, `ahead` seconds long if it is implicit, else 0.

    A motor whose known part is beyond its limit gives its limit, which does not depend on what the
    step brings and so has no implicit part.
    """
    asked = torque(action, angle, rate, ahead=ahead)
    inertia = added_inertia(action, ahead)
    if limits is None:
        return Drive(asked, inertia)
    beyond = _beyond(asked, limits)
    return Drive(_within(asked, limits), jnp.where(beyond, 0.0, inertia))


def given(
    action: Action,
    angle: Float[Array, " joint"],
    rates: tuple[Float[Array, " joint"], Float[Array, " joint"]],
    limits: Limits | None,
    *,
    ahead: float,
) -> Float[Array, " joint"]:
    """Returns what motors gave in a step, N m.

    Args:
      action: that they were asked for.
      angle: before the step, rad.
      rates: before the step, and at the time that forces were taken at, rad/s.
      limits: of the motors; None for none.
      ahead: length of an implicit step, s; 0 of an explicit one.
    """
    before, taken = rates
    gave = torque(action, angle, taken, ahead=ahead)
    if limits is None:
        return gave
    asked = torque(action, angle, before, ahead=ahead)
    return jnp.where(_beyond(asked, limits), _within(asked, limits), gave)


def scaled(
    anatomy: Anatomy, values: Float[Array, " motor"], *, acting: Literal["target", "torque"]
) -> Action:
    """Returns the action that numbers from -1 to 1 stand for.

    Args:
      anatomy: whose motors say what 0 and 1 are.
      values: one for each motor; beyond -1 and 1 they count as these.
      acting: whether they are targets of joints, within their limits, or torques.
    """
    motors, coordinates = anatomy.motors, anatomy.coordinates
    strength, centre, damping, stiffness = (
        jnp.asarray(np.array([getattr(each, name) for each in motors], np.float32))
        for name in ("strength", "centre", "damping", "stiffness")
    )
    asked = strength * jnp.clip(values, -1.0, 1.0)
    nothing = jnp.zeros_like(values)
    if acting == "torque":
        return Action(asked, nothing, nothing, damping)
    ends = [coordinates[each.coordinate] for each in motors]
    lower, upper = (
        np.array([getattr(each, end) for each in ends], np.float32) for end in ("lower", "upper")
    )
    return Action(nothing, jnp.clip(centre + asked, lower, upper), stiffness, damping)


def sprung(
    springs: Springs,
    angle: Float[Array, " joint"],
    rate: Float[Array, " joint"],
    *,
    ahead: float,
) -> Drive:
    """Returns what passive springs and dampers do in a step, as `driven` does of motors."""
    off_rest = springs.rest - angle - ahead * rate
    inertia = ahead * (springs.damping + ahead * springs.stiffness)
    push = jnp.asarray(springs.stiffness * off_rest - springs.damping * rate)
    return Drive(push, jnp.asarray(inertia))


def rubbed(
    friction: Float[np.ndarray, " joint"], rate: Float[Array, " joint"], *, ahead: float
) -> Drive:
    """Returns what Coulomb friction does to joints in a step, as `driven` does of motors.

    It is a damper that is the weaker the faster a joint moves as the step begins.

    Args:
      friction: torque against a joint that moves, N m.
      rate: before the step, rad/s.
      ahead: length of an implicit step, s; 0 of an explicit one.
    """
    damping = jnp.asarray(friction) / jnp.maximum(jnp.abs(rate), FRICTION_RATE)
    return Drive(-damping * rate, ahead * damping)


def _beyond(asked: Float[Array, " joint"], limits: Limits) -> Bool[Array, " joint"]:
    return (asked < limits.lowest) | (asked > limits.highest)


def _within(asked: Float[Array, " joint"], limits: Limits) -> Float[Array, " joint"]:
    return jnp.clip(asked, limits.lowest, limits.highest)
