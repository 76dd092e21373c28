"""The biped of Reil & Massey as a tree of links: its coordinates, compiled models, and anatomy.

Source as in `reil.py`. Fourteen coordinates: the hips' midpoint x, y and z, yaw, pitch and roll of
the trunk, and hip roll, hip pitch, knee and ankle of each leg.
"""

import functools
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mjxwalk.envs import dynamics, floating
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.anatomy import LEGS, Anatomy, Sense
from mjxwalk.envs.derived_anatomy import Strength, derive
from mjxwalk.envs.legged_body import Sprung

MODEL_PATH = Path(__file__).with_name("reil.xml")
SPHERES = tuple(f"{end}_{leg}" for leg in LEGS for end in ("heel", "toe"))
SPHERE_RADIUS = 0.08  # m; Table 1
FOOT_DENSITY = 1_000.0  # kg/m^3; Table 1
LEG = 1.04  # m, hip to ankle with the leg straight; Table 1, thigh and calf abut
EULER = slice(3, 6)  # of the coordinates; yaw, pitch and roll
JOINTS = slice(6, 14)
HIPS = np.array([7, 11])  # hip pitch, left and right
NUM_COORDINATES = 14
_ANGLES = tuple(f"{j}_{leg}" for leg in LEGS for j in ("hip_roll", "hip", "knee", "ankle"))
_TORSO = ("yaw", "pitch", "roll")
SENSES = (
    Sense("time", "s", "since the start of the trial"),
    Sense(
        "torso", "rad", "yaw, pitch and roll (z-y-x): left, forward and right are positive", _TORSO
    ),
    Sense("torso_rate", "rad/s", "of the trunk's angles", _TORSO),
    Sense("angle", "rad", "of each leg's joints, flexion and toes up positive", _ANGLES),
    Sense("rate", "rad/s", "of each leg's joints", _ANGLES),
    Sense("contact", "", "whether the left and the right foot touch the ground", LEGS),
    Sense("ankle_x", "m", "how far the left and the right ankle are ahead of the hips", LEGS),
)
# rad; ours: what pattern generators that walk ask of the hips
STRENGTH = Strength("velocity", (0.5, 0.5), centre=1.0)


class Offsets(NamedTuple):
    """Where parts are joined, which the paper does not give.

    Attributes:
      hip: from the midline to either hip, m.
      trunk: of the trunk's centre over the hips, m.
      heel: of the heel's sphere ahead of the ankle, m; negative is behind.
      toe: of the toe's sphere ahead of the ankle, m.
      sole: of both spheres' centres below the ankle, m.
    """

    hip: float
    trunk: float
    heel: float
    toe: float
    sole: float


def build_spec(offsets: Offsets) -> Any:
    """Returns the `mujoco.MjSpec` of the body, its parts put in place."""
    spec = mujoco.MjSpec.from_file(str(MODEL_PATH))
    spec.body("torso").first_geom().pos = [0.0, 0.0, offsets.trunk]
    sphere = FOOT_DENSITY * 4.0 / 3.0 * math.pi * SPHERE_RADIUS**3  # kg
    half = 0.5 * (offsets.toe - offsets.heel)
    own = 2.0 * 0.4 * sphere * SPHERE_RADIUS**2
    across = own + 2.0 * sphere * half**2
    for leg, side in zip(LEGS, (1.0, -1.0), strict=True):
        spec.body(f"hip_{leg}").pos = [0.0, side * offsets.hip, 0.0]
        foot = spec.body(f"foot_{leg}")
        foot.mass = 2.0 * sphere
        foot.ipos = [offsets.heel + half, 0.0, -offsets.sole]
        foot.inertia = [own, across, across]
        for end, x in (("heel", offsets.heel), ("toe", offsets.toe)):
            spec.geom(f"{end}_{leg}").pos = [x, 0.0, -offsets.sole]
            foot.add_site(name=f"{end}_{leg}", pos=[x, 0.0, -offsets.sole])
    return spec


def whole_spec(offsets: Offsets, sprung: Sprung, max_torque: float) -> Any:
    """Returns the `mujoco.MjSpec` with springs and dampers, and motors that give plain torques."""
    made = build_spec(offsets)
    stiffness, rest, damping = sprung.springs
    for joint, name in zip(sprung.joints.tolist(), range(len(stiffness)), strict=True):
        found = made.joint(_ANGLES[joint])
        found.stiffness[0], found.damping[0] = float(stiffness[name]), float(damping[name])
        found.springref = float(rest[name])
    for leg in LEGS:
        motor = made.add_actuator(
            name=f"hip_{leg}", target=f"hip_{leg}", trntype=mujoco.mjtTrn.mjTRN_JOINT
        )
        motor.set_to_motor()
        motor.ctrllimited, motor.ctrlrange = True, [-max_torque, max_torque]
    return made


@functools.cache
def anatomy(offsets: Offsets, knee: tuple[float, float], max_torque: float) -> Anatomy:
    """Returns the anatomy of the body.

    Args:
      offsets: where parts are joined.
      knee: where the knee cap stops it, rad.
      max_torque: of the motors, N m.
    """
    return derive(
        hinged_model(offsets).mujoco,
        name="Reil",
        motors=[f"hip_{leg}" for leg in LEGS],
        points=SPHERES,
        senses=SENSES,
        limits=np.array([[-max_torque, max_torque]] * 2),
        ranges={f"knee_{leg}": knee for leg in LEGS},
        radius=SPHERE_RADIUS,
        strength=STRENGTH,
    )


@functools.cache
def hinged_model(offsets: Offsets) -> dynamics.Model:
    """Returns the compiled body with a hinge for each of the trunk's angles."""
    return dynamics.compile_model(build_spec(offsets))


@functools.cache
def floating_model(offsets: Offsets) -> dynamics.Model:
    """Returns the compiled body with a free root."""
    return dynamics.compile_model(floating.freed(build_spec(offsets), "torso"))


@functools.cache
def standing_height(offsets: Offsets) -> float:
    """Returns how high the centre of mass is over the soles when standing straight, m."""
    model = hinged_model(offsets).mujoco
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return float(data.subtree_com[1, 2]) + LEG + offsets.sole + SPHERE_RADIUS
