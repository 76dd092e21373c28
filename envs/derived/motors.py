"""The actuators of a file as motors of joints: torque limits, and gains where it has them."""

from typing import Any, NamedTuple

import numpy as np

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.anatomy import HINGE, SLIDE
from mjxwalk.envs.derived.file_tree import FileTree

_JOINT = {int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)}
_TARGETS = {
    mujoco.mjtTrn.mjTRN_TENDON: "tendon",
    mujoco.mjtTrn.mjTRN_SITE: "site",
    mujoco.mjtTrn.mjTRN_SLIDERCRANK: "crank",
    mujoco.mjtTrn.mjTRN_BODY: "whole body",
}
_AFFINE = int(mujoco.mjtBias.mjBIAS_AFFINE)
_FIXED = int(mujoco.mjtGain.mjGAIN_FIXED)

# ours, for what a file leaves open. A torque is in weights times heights of the root, a time in
# the time that a fall from that height would need, over the square root of two. Robots' own gains
# are often too soft to stand by: an ankle below half a weight times height a rad falls over.
STRENGTH = 0.5  # of a motor without limits
REACH = 0.05  # rad off its target at which a motor gives all it has
STIFFEST = 1.5  # a rad
DAMPING_TIME = 0.1  # of a motor's damping over its stiffness


class JointMotor(NamedTuple):
    """What drives one coordinate below the root.

    Attributes:
      joint: its place in `FileTree.joints`.
      lowest: torque that it can give at least, N m; minus infinity where the file limits nothing.
      highest: torque that it can give at most, N m.
      stiffness: of a motor that holds a position by itself, N m/rad; else 0.
      damping: N m s/rad.
    """

    joint: int
    lowest: float
    highest: float
    stiffness: float
    damping: float


def of_tree(tree: FileTree) -> tuple[JointMotor, ...]:
    """Returns the motors, in the order of the coordinates.

    Raises:
      ValueError: an actuator drives no joint, or drives it in a way that no motor here can.
    """
    model = tree.source.model
    numbers = [each.joint for each in tree.joints]
    found: dict[int, JointMotor] = {}
    for actuator in range(model.nu):
        name = str(model.actuator(actuator).name) or f"number {actuator}"
        joint = _joint(model, actuator, name)
        if joint not in numbers:
            raise ValueError(
                f"actuator {name} drives the root, which nothing holds; remove the actuator"
            )
        place = numbers.index(joint)
        one = _motor(model, actuator, name, place)
        if place in found:
            other = found[place]
            one = JointMotor(
                place,
                other.lowest + one.lowest,
                other.highest + one.highest,
                other.stiffness + one.stiffness,
                other.damping + one.damping,
            )
        found[place] = one
    if not found:
        raise ValueError("the body has no actuators; add <motor joint=.../> for each driven joint")
    return tuple(_within(model, tree, found[place]) for place in sorted(found))


def add(spec: Any, tree: FileTree) -> Any:
    """Returns the `mujoco.MjSpec` of the tree with motors that give torques within their limits."""
    for each in of_tree(tree):
        name = tree.joints[each.joint].name
        limits = np.array([each.lowest, each.highest])
        limited = np.isfinite(limits).all()
        spec.add_actuator(
            name=name,
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            forcelimited=mujoco.mjtLimited(int(limited)),
            forcerange=limits if limited else np.zeros(2),
        )
    return spec


def usual_gains(strongest: float, usual: float, time: float) -> tuple[float, float]:
    """Returns stiffness, N m/rad, and damping, N m s/rad, of a motor that has none of its own.

    Args:
      strongest: torque that it gives at most, N m; infinite where nothing limits it.
      usual: weight times height of the root, N m.
      time: that a fall from that height would need, over the square root of two, s.
    """
    strongest = min(strongest, STRENGTH * usual)
    stiffness = min(strongest / REACH, STIFFEST * usual)
    return stiffness, DAMPING_TIME * time * stiffness


def _joint(model: Any, actuator: int, name: str) -> int:
    kind = int(model.actuator_trntype[actuator])
    joint = int(model.actuator_trnid[actuator][0])
    if kind not in _JOINT or int(model.jnt_type[joint]) not in (HINGE, SLIDE):
        names = {int(value): word for value, word in _TARGETS.items()}
        raise ValueError(
            f"actuator {name} drives a {names.get(kind, 'ball or free joint')}, and contact law "
            "points has motors of hinges and slides alone; write <motor joint=.../> in its place"
        )
    return joint


def _motor(model: Any, actuator: int, name: str, place: int) -> JointMotor:
    gear = float(model.actuator_gear[actuator][0])
    if not gear:
        raise ValueError(
            f"actuator {name} moves nothing, as its gear is 0; correct it, or remove the actuator"
        )
    bias = model.actuator_biasprm[actuator]
    affine = int(model.actuator_biastype[actuator]) == _AFFINE
    plain = int(model.actuator_gaintype[actuator]) == _FIXED
    if not plain or int(model.actuator_biastype[actuator]) > _AFFINE:
        raise ValueError(
            f"actuator {name} is a muscle or has a gain that changes, which contact law points "
            "cannot; write <motor joint=.../> in its place"
        )
    stiffness, damping = (-(gear**2) * bias[1], -(gear**2) * bias[2]) if affine else (0.0, 0.0)
    least, most = -np.inf, np.inf
    if not stiffness and not damping and model.actuator_ctrllimited[actuator]:
        gain = float(model.actuator_gainprm[actuator][0]) * gear
        least, most = sorted(gain * model.actuator_ctrlrange[actuator])
    if model.actuator_forcelimited[actuator]:
        low, high = sorted(gear * model.actuator_forcerange[actuator])
        least, most = max(least, low), min(most, high)
    return JointMotor(place, float(least), float(most), float(stiffness), float(damping))


def _within(model: Any, tree: FileTree, motor: JointMotor) -> JointMotor:
    """Returns the motor with the limits that its joint has for all actuators together."""
    joint = tree.joints[motor.joint].joint
    if not model.jnt_actfrclimited[joint]:
        return motor
    low, high = model.jnt_actfrcrange[joint]
    return motor._replace(
        lowest=max(motor.lowest, float(low)), highest=min(motor.highest, float(high))
    )
