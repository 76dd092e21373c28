"""What of a file contact law `mujoco` cannot do, and refuses by name."""

from collections.abc import Generator
from typing import Any

import numpy as np

from mjxwalk.envs._mujoco import mujoco

_ROOT = 1  # number of the body
_HELD = "damping, armature, frictionloss, stiffness and range"
_FLAGS = {
    "contact": int(mujoco.mjtDisableBit.mjDSBL_CONTACT),
    "constraint": int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT),
}


def check(model: Any) -> None:
    """Raises unless the law does all that a file says; of what MJX refuses, MJX tells itself.

    Args:
      model: the `mujoco.MjModel` of the file.

    Raises:
      ValueError: something is left; the message names the first.
    """
    for what in _lost(model):
        raise ValueError(f"contact law mujoco: {what}, or use contact law points")


def _is_held(model: Any, joint: int, dof: int) -> bool:
    """Returns whether a joint has more than inertia of what it carries."""
    found = model.dof_damping, model.dof_armature, model.dof_frictionloss
    return bool(
        any(values[dof] for values in found)
        or model.jnt_stiffness[joint]
        or model.jnt_limited[joint]
    )


def _lost(model: Any) -> Generator[str]:
    """Yields what would be lost, in words."""
    for name, bit in _FLAGS.items():
        if int(model.opt.disableflags) & bit:
            yield f"a <flag> disables {name}, without which nothing stands; remove it"
    if int(model.opt.noslip_iterations):
        yield "it has no noslip_iterations; remove them from the <option>"
    for joint in range(int(model.njnt)):
        name = f"joint {model.joint(joint).name or joint}"
        dof = int(model.jnt_dofadr[joint])
        if int(model.jnt_bodyid[joint]) == _ROOT and _is_held(model, joint, dof):
            yield f"{name} moves the root, which nothing may hold; remove its {_HELD}"
        if model.jnt_actgravcomp[joint]:
            yield f"motors do not carry gravity of {name}; remove its actuatorgravcomp"
        if np.any(model.jnt_stiffnesspoly[joint]) or np.any(model.dof_dampingpoly[dof]):
            yield f"{name} has higher terms of spring or damper; keep the first number of each"
    for tendon in range(int(model.ntendon)):
        terms = model.tendon_stiffnesspoly[tendon], model.tendon_dampingpoly[tendon]
        if np.any(terms):
            name = f"tendon {model.tendon(tendon).name or tendon}"
            yield f"{name} has higher terms of spring or damper; keep the first number of each"
