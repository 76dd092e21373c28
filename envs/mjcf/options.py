"""Writes a model's options and flags."""

from typing import Any

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf.elements import element, numbers, unlike
from mjxwalk.envs.mjcf.kept import Kept


def option(model: Any) -> list[str]:
    """Returns the element of the options that differ from MuJoCo's defaults."""
    given = model.opt
    plain = mujoco.MjOption()
    overridden = int(given.enableflags) & int(mujoco.mjtEnableBit.mjENBL_OVERRIDE)
    names = [
        "timestep",
        "impratio",
        "tolerance",
        "ls_tolerance",
        "noslip_tolerance",
        "ccd_tolerance",
        "gravity",
        "wind",
        "density",
        "viscosity",
        "iterations",
        "ls_iterations",
        "noslip_iterations",
        "ccd_iterations",
        *(("o_margin", "o_solref", "o_solimp", "o_friction") if overridden else ()),
    ]
    attributes = unlike({name: (getattr(given, name), getattr(plain, name)) for name in names})
    for name, kind in (
        ("integrator", mujoco.mjtIntegrator),
        ("cone", mujoco.mjtCone),
        ("jacobian", mujoco.mjtJacobian),
        ("solver", mujoco.mjtSolver),
    ):
        if getattr(given, name) != getattr(plain, name):
            word = kind(int(getattr(given, name))).name.partition("_")[2]
            attributes[name] = {"EULER": "Euler", "NEWTON": "Newton"}.get(
                word, word if word in ("RK4", "PGS", "CG") else word.lower()
            )
    groups = [each for each in range(31) if int(given.disableactuator) >> each & 1]
    if groups:
        attributes["actuatorgroupdisable"] = numbers(groups)
    flags = {
        **_flags(mujoco.mjtDisableBit, int(given.disableflags), "disable"),
        **_flags(mujoco.mjtEnableBit, int(given.enableflags), "enable"),
    }
    if not attributes and not flags:
        return []
    return element("option", attributes, element("flag", flags) if flags else ())


def _flags(kinds: Any, bits: int, word: str) -> dict[str, str]:
    return {
        name.partition("_")[2].lower(): word
        for name, kind in kinds.__members__.items()
        if name.startswith(("mjDSBL", "mjENBL")) and int(kind) & bits
    }


def statistic(kept: Kept) -> list[str]:
    """Returns the element of the statistics that the file gave."""
    attributes = {name: numbers(value) for name, value in kept.statistic.items()}
    return element("statistic", attributes) if attributes else []
