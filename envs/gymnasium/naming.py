"""What the numbers of an observation are called, and ranges of them as settings."""

from collections.abc import Sequence
from typing import Any

from mjxwalk.envs import checks
from mjxwalk.envs.derived.source import FREE

_PLACES = ("x", "y", "z", "quaternion w", "quaternion x", "quaternion y", "quaternion z")
_RATES = ("x rate", "y rate", "z rate", "turning x", "turning y", "turning z")
_SPATIAL = ("torque x", "torque y", "torque z", "force x", "force y", "force z")
_VELOCITY = ("turning x", "turning y", "turning z", "velocity x", "velocity y", "velocity z")
_INERTIA = ("xx", "yy", "zz", "xy", "xz", "yz", "mass x", "mass y", "mass z", "mass")


def positions(found: Any) -> list[str]:
    """Returns the names of `qpos`, of a `mujoco.MjModel`."""
    return _of_joints(found, _PLACES, "")


def rates(found: Any) -> list[str]:
    """Returns the names of `qvel`."""
    return _of_joints(found, _RATES, " rate")


def motors(found: Any) -> list[str]:
    """Returns the names of `qfrc_actuator`."""
    return _of_joints(found, _SPATIAL[3:] + _SPATIAL[:3], " torque")


def inertias(found: Any) -> list[str]:
    """Returns the names of `cinert` of all bodies but the world."""
    return _of_bodies(found, "inertia", _INERTIA)


def velocities(found: Any) -> list[str]:
    """Returns the names of `cvel` of all bodies but the world."""
    return _of_bodies(found, "", _VELOCITY)


def contacts(found: Any) -> list[str]:
    """Returns the names of `cfrc_ext` of all bodies but the world."""
    return _of_bodies(found, "contact", _SPATIAL)


def check_range(settings: Any, field: str) -> None:
    """Raises ValueError unless a setting is two numbers that rise."""
    lower, upper = getattr(settings, field)
    if not -checks.LARGEST <= lower < upper <= checks.LARGEST:
        raise ValueError(
            f"{field} must be two numbers that rise, from {-checks.LARGEST:g} to "
            f"{checks.LARGEST:g}, got {lower:g} and {upper:g}"
        )


def _of_joints(found: Any, root: Sequence[str], ending: str) -> list[str]:
    names: list[str] = []
    for joint in range(found.njnt):
        name = str(found.joint(joint).name)
        free = int(found.jnt_type[joint]) == FREE
        names += [f"{name} {each}" for each in root] if free else [f"{name}{ending}"]
    return names


def _of_bodies(found: Any, what: str, parts: Sequence[str]) -> list[str]:
    bodies = [str(found.body(body).name) for body in range(1, found.nbody)]
    return [" ".join(filter(None, (body, what, part))) for body in bodies for part in parts]
