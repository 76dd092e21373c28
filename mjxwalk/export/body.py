"""A walker's body as MJCF, with the numbers of its experiment."""

from typing import Any

import numpy as np

from mjxwalk.envs import Flame, Planar7, flame_body, planar7
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.errors import RunError


def as_mjcf(env: Any) -> bytes:
    """Returns the body's XML.

    It has motors on all driven joints, and joint limits, which MuJoCo enforces by its own solver.
    The law of our ground and of our joint stops is in `custom`, as MuJoCo has no such law; the
    feet's points are sites, and shapes do not collide.

    Raises:
      RunError: the body is not known here.
    """
    if isinstance(env, Planar7):
        spec = mujoco.MjSpec.from_file(str(planar7.MODEL_PATH))
    elif isinstance(env, Flame):
        spec = mujoco.MjSpec.from_file(str(flame_body.MODEL_PATH))
        _couple(spec, env)
    else:
        raise RunError(f"a {type(env).__name__} cannot be exported; Planar7 and Flame can")
    model = env.model.mujoco
    for body in spec.bodies[1:]:
        body.mass = float(model.body(body.name).mass[0])
        body.inertia = np.array(model.body(body.name).inertia)
    spec.option.timestep = env.timestep
    laws = {
        "contact_stiffness": env.contact.stiffness,
        "contact_damping": env.contact.damping,
        "contact_friction": env.contact.friction,
        "joint_stop_stiffness": env.joint_stop.stiffness,
        "joint_stop_damping": env.joint_stop.damping,
    }
    for name, value in laws.items():
        spec.add_numeric(name=name, data=[value], size=1)
    spec.compile()
    return spec.to_xml().encode()


def _couple(spec: Any, env: Flame) -> None:
    """Adds what `Flame` does in code: the shared adduction, the ankles' roll, and the motors."""
    spec.add_equality(
        name="adduction",
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1="adduction_right",
        name2="adduction_left",
        data=[0.0, 1.0] + [0.0] * 10,
    )
    for leg in flame_body.LEGS:
        roll = spec.joint(f"ankle_roll_{leg}")
        roll.stiffness[0], roll.damping[0] = env.ankle_roll_stiffness, env.ankle_roll_damping
    names = ["adduction_left", *(f"{j}_{s}" for s in flame_body.LEGS for j in planar7.JOINTS)]
    for name in names:
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_motor()
