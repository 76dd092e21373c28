"""A walker's body as MJCF, with the numbers of its experiment."""

import numpy as np

from mjxwalk.envs import LeggedEnv
from mjxwalk.envs._mujoco import compiled


def as_mjcf(env: LeggedEnv) -> bytes:
    """Returns the body's XML.

    It has springs, motors on all driven joints, and joint limits, which MuJoCo enforces by its own
    solver. The law of our ground and of our joint stops is in `custom`, as MuJoCo has no such law;
    the feet's points are sites, and shapes do not collide.
    """
    spec, model = env.spec(), env.model.mujoco
    for body in spec.bodies[1:]:
        found = model.body(body.name)
        body.mass, body.inertia = float(found.mass[0]), np.array(found.inertia)
        body.ipos, body.iquat = np.array(found.ipos), np.array(found.iquat)
        body.explicitinertial = True
    for joint, place in enumerate(env.anatomy.joint_coordinate):
        coordinate = env.anatomy.coordinates[place]
        limits = np.array([coordinate.lower, coordinate.upper])
        if not model.jnt_limited[joint] and np.isfinite(limits).all():  # a setting of ours
            limited = spec.joint(model.joint(joint).name)
            limited.limited = True
            limited.range = np.degrees(limits) if spec.compiler.degree else limits
    spec.option.timestep = env.timestep
    laws = {
        "contact_stiffness": env.contact.stiffness,
        "contact_damping": env.contact.damping,
        "contact_friction": env.contact.friction,
        "joint_stop_stiffness": env.stop_law.stiffness,
        "joint_stop_damping": env.stop_law.damping,
    }
    for old in [each for each in spec.numerics if each.name in laws]:
        spec.delete(old)  # of a body that was exported before
    for name, value in laws.items():
        spec.add_numeric(name=name, data=[value], size=1)
    compiled(spec)
    return spec.to_xml().encode()
