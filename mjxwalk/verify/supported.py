"""What of a body we have laws for; all else is refused before any work."""

from collections.abc import Generator
from typing import Any

from mjxwalk.envs import (
    Course,
    FitnessTerms,
    JointStop,
    LeggedEnv,
    Payload,
    Push,
    SoftContact,
    VelocityMotor,
    own_laws,
)
from mjxwalk.verify import laws, senses

# Methods that move walkers or end their trials, and may be a body's own.
METHODS = ("step", "passive", "drive", "carried", "ankles", "is_low", "is_over", "fitness")
KNOWN = {  # laws of a body's own, by the method that has them
    "drive": (VelocityMotor, own_laws.Righting),
    "carried": (own_laws.TorsoLoad,),
    "ankles": (own_laws.AlongHeading,),
    "is_low": (own_laws.LowCentre, own_laws.Forbidden),
    "is_over": (own_laws.Arrival, own_laws.Standstill),
    "fitness": (own_laws.HindmostAnkle, FitnessTerms),
}


def check(name: str, env: Any) -> None:
    """Raises unless we have laws for all that a walker's body does.

    Args:
      name: of the walker.
      env: its environment.

    Raises:
      ValueError: we lack one; the message names it.
    """
    kind = type(env).__name__
    if not isinstance(env, LeggedEnv):
        raise ValueError(f"{name} cannot be verified, as its body {kind} is no LeggedEnv")
    for missing in _missing(env):
        raise ValueError(
            f"{name} cannot be verified, as there is no second law for {missing} of {kind}"
        )


def _missing(env: LeggedEnv) -> Generator[str]:
    """Yields what we have no law for, in words."""
    for what, value, known in (
        ("ground", env.terrain, laws.GROUNDS),
        ("course", env.course, (Course,)),
        ("push", env.push, (Push,)),
        ("payload", env.payload, (Payload,)),
        ("contact", env.contact, (SoftContact,)),
        ("joint stops", env.stop_law, (JointStop,)),
    ):
        if type(value) not in known:
            yield f"the {what} {type(value).__name__}"
    law = getattr(env, "contact_law", "points")
    if law == "mujoco" and env.course.has_soil:
        yield "soft and slippery ground under the contact law mujoco"
    yield from _missing_methods(env)
    for method, own in env.own_laws().items():
        for law in own:
            if type(law) not in KNOWN.get(method, ()):
                yield f"the law {type(law).__name__} in `{method}`"
    yield from _missing_motors(env)
    for sense in env.anatomy.senses:
        if not senses.known(env.anatomy, sense):
            yield f"the sense {sense.name}"


def _missing_methods(env: LeggedEnv) -> Generator[str]:
    """Yields methods of the body's own that its own laws, older or silent, do not tell of."""
    told, teller = env.own_laws(), _owner(env, "own_laws")
    for method in METHODS:
        owner = _owner(env, method)
        usual = issubclass(LeggedEnv, owner)
        if usual or (method in told and issubclass(teller, owner)):
            continue
        yield f"the method `{method}`, which `own_laws` should tell of,"


def _missing_motors(env: LeggedEnv) -> Generator[str]:
    kinds = {motor.law for motor in env.anatomy.motors}
    drive = [type(law) for law in env.own_laws().get("drive", ())]
    if kinds == {"velocity"} and VelocityMotor not in drive:
        yield "motors by velocity, whose VelocityMotor `own_laws` should have,"
    elif kinds not in ({"velocity"}, {"torque"}, {"position"}):
        yield f"motors by {' and '.join(sorted(kinds)) or 'nothing'}"


def _owner(env: LeggedEnv, name: str) -> type:
    """Returns the class that an attribute of an environment's class is of."""
    return next(each for each in type(env).__mro__ if name in vars(each))
