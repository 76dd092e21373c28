"""The legs of a body that a user brings: joints, motors, and that right mirrors left."""

from typing import Any

import numpy as np
from jaxtyping import Float

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.anatomy import MIRROR
from mjxwalk.envs.body_contract import Contract
from mjxwalk.envs.motor import Springs


def check_joints(model: Any, contract: Contract) -> None:
    """Checks what joints have besides their axes.

    Raises:
      ValueError: one has what is not simulated, or lacks its range.
    """
    root = {joint.name for joint in contract.links[0].joints}
    for joint in range(model.njnt):
        name = str(model.joint(joint).name)
        dof = int(model.jnt_dofadr[joint])
        unknown = {
            "frictionloss": model.dof_frictionloss[dof],
            "a stiffness that is no number": np.any(model.jnt_stiffnesspoly[joint]),
            "a damping that is no number": np.any(model.dof_dampingpoly[dof]),
            "ref": model.qpos0[model.jnt_qposadr[joint]],
            "actuatorgravcomp": model.jnt_actgravcomp[joint],
        }
        if name in root:
            unknown |= {
                "stiffness": model.jnt_stiffness[joint],
                "damping": model.dof_damping[dof],
                "armature": model.dof_armature[dof],
                "a range": model.jnt_limited[joint],
            }
        for words, value in unknown.items():
            if value:
                raise ValueError(f"joint {name} has {words}, which is not simulated; remove it")
        if name not in root and not model.jnt_limited[joint]:
            raise ValueError(f"joint {name} has no range; give it one, where its soft stops begin")
        lower, upper = model.jnt_range[joint]
        if name not in root and not lower <= 0.0 <= upper:
            raise ValueError(
                f"joint {name} has the range {lower:.4g} to {upper:.4g} rad, which must hold 0, "
                "the angle of a straight leg"
            )


def check_motors(model: Any, contract: Contract) -> None:
    """Checks that there is no actuator, or one motor for every joint that may have one.

    Raises:
      ValueError: one is of another kind, on another joint, or missing.
    """
    driven: list[str] = []
    for actuator in range(model.nactuator):
        name = model.actuator(actuator).name or f"number {actuator}"
        plain = (
            int(model.actuator_dyntype[actuator]) == int(mujoco.mjtDyn.mjDYN_NONE)
            and int(model.actuator_gaintype[actuator]) == int(mujoco.mjtGain.mjGAIN_FIXED)
            and int(model.actuator_biastype[actuator]) == int(mujoco.mjtBias.mjBIAS_NONE)
            and int(model.actuator_trntype[actuator]) == int(mujoco.mjtTrn.mjTRN_JOINT)
            and model.actuator_gear[actuator][0] != 0.0
        )
        added = (model.actuator_damping, model.actuator_armature, model.actuator_delay)
        if not plain or any(np.any(each[actuator]) for each in added):
            raise ValueError(
                f"actuator {name} is no plain motor of a joint; write <motor joint=.../>, as "
                "controllers give torques (springs and dampers belong to the joint)"
            )
        joint = str(model.joint(int(model.actuator_trnid[actuator][0])).name)
        if joint not in contract.motors or joint in driven:
            raise ValueError(
                f"actuator {name} drives {joint}, and there is one motor for each of "
                f"{', '.join(contract.motors)}; remove it"
            )
        driven.append(joint)
    missing = [name for name in contract.motors if name not in driven]
    if driven and missing:
        raise ValueError(
            f"has motors, but none for {', '.join(missing)}; add them, or remove all for motors "
            "without limits of their own"
        )


def check_mirrored(model: Any, contract: Contract, close: float) -> None:
    """Checks that the right leg mirrors the left, as stance and swing share a network.

    Raises:
      ValueError: it does not.
    """
    for link in contract.links:
        if not link.name.endswith("_left"):
            continue
        other = f"{link.name.removesuffix('left')}right"
        left, right = model.body(link.name), model.body(other)
        _alike(link.name, other, "pos", left.pos, MIRROR @ right.pos, close)
        _alike(link.name, other, "mass", left.mass, right.mass, close)
        _alike(link.name, other, "centre of mass", left.ipos, MIRROR @ right.ipos, close)
        turned = MIRROR @ inertia(model, right.id) @ MIRROR
        _alike(link.name, other, "inertia", inertia(model, left.id), turned, close)
        for joint in link.joints:
            twin = f"{joint.name.removesuffix('left')}right"
            one, two = model.joint(joint.name).id, model.joint(twin).id
            for name, values in _of_joints(model).items():
                _alike(joint.name, twin, name, values[one], values[two], close)
    for site, _ in contract.sites:
        if site.endswith("_left"):
            twin = f"{site.removesuffix('left')}right"
            one, two = model.site(site).pos, MIRROR @ model.site(twin).pos
            _alike(site, twin, "pos", one, two, close)


def _of_joints(model: Any) -> dict[str, Any]:
    """Returns what belongs to each joint, by what it is called."""
    limits = np.array([torque_limits(model, joint) for joint in range(model.njnt)])
    return {
        "range": model.jnt_range,
        "stiffness": model.jnt_stiffness,
        "damping": model.dof_damping,
        "armature": model.dof_armature,
        "springref": model.qpos_spring,
        "torque limits": np.nan_to_num(limits),
    }


def _alike(left: str, right: str, what: str, one: Any, other: Any, close: float) -> None:
    if not np.allclose(one, other, rtol=close, atol=close):
        shown = [" ".join(f"{v:.6g}" for v in np.ravel(each)) for each in (one, other)]
        raise ValueError(
            f"{right} does not mirror {left}: its {what} would have to be {shown[0]} seen in the "
            f"mirror, and is {shown[1]}; make both sides the same"
        )


def inertia(model: Any, body: int) -> Any:
    """Returns a body's matrix of inertia about its centre of mass, along its axes, kg m^2."""
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[body])
    axes = turn.reshape(3, 3)
    return axes @ np.diag(model.body_inertia[body]) @ axes.T


def torque_limits(model: Any, joint: int) -> tuple[float, float]:
    """Returns the least and greatest torque of a joint's motor, N m; infinite where not limited."""
    lowest, highest = -np.inf, np.inf
    if model.jnt_actfrclimited[joint]:
        lowest, highest = model.jnt_actfrcrange[joint]
    for actuator in range(model.nactuator):
        if int(model.actuator_trnid[actuator][0]) != joint:
            continue
        gain, gear = model.actuator_gainprm[actuator][0], model.actuator_gear[actuator][0]
        low, high = -np.inf, np.inf
        if model.actuator_ctrllimited[actuator]:
            low, high = sorted(gain * model.actuator_ctrlrange[actuator])
        if model.actuator_forcelimited[actuator]:
            least, most = model.actuator_forcerange[actuator]
            low, high = max(low, least), min(high, most)
        low, high = sorted((gear * low, gear * high))
        lowest, highest = max(lowest, low), min(highest, high)
    return float(lowest), float(highest)


def torque_limits_of(model: Any, joints: list[int]) -> Float[np.ndarray, "motor 2"]:
    """Returns the least and greatest torque of motors on these joints, N m."""
    return np.array([torque_limits(model, joint) for joint in joints])


def springs(model: Any, joints: list[list[int]]) -> Springs | None:
    """Returns the passive springs and dampers of coordinates; None if there are none.

    Args:
      model: of the body, hinges and slides only.
      joints: that each coordinate moves.
    """
    stiffness = np.array([model.jnt_stiffness[each].sum() for each in joints])
    pull = np.array([(model.jnt_stiffness * model.qpos_spring)[each].sum() for each in joints])
    damping = np.array([model.dof_damping[each].sum() for each in joints])
    if not stiffness.any() and not damping.any():
        return None
    rest = pull / np.where(stiffness > 0.0, stiffness, 1.0)
    return Springs(*(each.astype(np.float32) for each in (stiffness, rest, damping)))
