"""Gives a body whose file has no actuators a motor for each hinge."""

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.derived import anatomy
from mjxwalk.envs.derived import motors as mjcf_motors
from mjxwalk.envs.mjcf.elements import element, numbers
from mjxwalk.envs.mjcf.kept import Kept

_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)


def of_body(kept: Kept, text: str) -> tuple[list[list[str]], str]:
    """Returns the elements of the motors, and a sentence that says so; none of what cannot walk.

    A motor gives what its joint's `actuatorfrcrange` lets it, which is a URDF's effort, and else a
    share of the body's weight times its height.

    Args:
      kept: the body.
      text: its MJCF.
    """
    model = kept.model
    joints = [
        joint
        for joint in kept.joints
        if int(model.jnt_type[joint]) == _HINGE and int(model.jnt_bodyid[joint]) not in kept.roots
    ]
    try:
        stance = anatomy.stance(text)
    except ValueError:  # which is said where an environment is made of it
        return [], ""
    most = float(f"{mjcf_motors.STRENGTH * stance.weight * stance.height:.2g}")
    free = [joint for joint in joints if not model.jnt_actfrclimited[joint]]
    motors = [
        element(
            "motor",
            {
                "name": kept.joints[joint],
                "joint": kept.joints[joint],
                "forcerange": numbers((-most, most)) if joint in free else None,
            },
        )
        for joint in joints
    ]
    num, own = len(joints), len(joints) - len(free)
    share = f"up to {most:g} N m, {mjcf_motors.STRENGTH:g} of weight times height"
    if not free:
        share = "up to the limit of its joint"
    elif own:
        share = f"{own} of them up to the limits of their joints, the others {share}"
    return motors, f"The file has no actuators; each of its {num} hinges has a motor, {share}."
