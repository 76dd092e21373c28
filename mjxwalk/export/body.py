"""A walker's body as MJCF, with the numbers of its experiment."""

from typing import Any

import numpy as np

from mjxwalk.envs import Flame, Planar7, flame_body, planar7_body
from mjxwalk.envs._mujoco import compiled, mujoco
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
        spec = planar7_body.spec(env.body)
    elif isinstance(env, Flame):
        spec = flame_body.spec(env.body)
        _couple(spec, env)
    else:
        raise RunError(f"a {type(env).__name__} cannot be exported; Planar7 and Flame can")
    model = env.model.mujoco
    for body in spec.bodies[1:]:
        found = model.body(body.name)
        body.mass, body.inertia = float(found.mass[0]), np.array(found.inertia)
        body.ipos, body.iquat = np.array(found.ipos), np.array(found.iquat)
        body.explicitinertial = True
    spec.option.timestep = env.timestep
    laws = {
        "contact_stiffness": env.contact.stiffness,
        "contact_damping": env.contact.damping,
        "contact_friction": env.contact.friction,
        "joint_stop_stiffness": env.joint_stop.stiffness,
        "joint_stop_damping": env.joint_stop.damping,
    }
    for old in [each for each in spec.numerics if each.name in laws]:
        spec.delete(old)  # of a body that was exported before
    for name, value in laws.items():
        spec.add_numeric(name=name, data=[value], size=1)
    compiled(spec)
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
    if spec.actuators:
        return
    names = ["adduction_left", *(f"{j}_{s}" for s in flame_body.LEGS for j in planar7_body.JOINTS)]
    for name in names:
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_motor()
