"""The biped of Reil & Massey as a tree of links: its coordinates, compiled models, and its start.

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

MODEL_PATH = Path(__file__).with_name("reil.xml")
LEGS = ("left", "right")
FEET = tuple(f"foot_{leg}" for leg in LEGS)
SPHERES = tuple(f"{end}_{leg}" for leg in LEGS for end in ("heel", "toe"))
SPHERE_RADIUS = 0.08  # m; Table 1
FOOT_DENSITY = 1_000.0  # kg/m^3; Table 1
LEG = 1.04  # m, hip to ankle with the leg straight; Table 1, thigh and calf abut
GRAVITY = 9.81  # m/s^2, as in MuJoCo
# ours: beyond these speeds a simulation has diverged; a foot that spins free reaches 100 rad/s.
MAX_SPEED = np.array([50.0] * 3 + [1000.0] * 11, np.float32)  # m/s, rad/s
EULER = slice(3, 6)  # of the coordinates; yaw, pitch and roll
YAW = 3
JOINTS = slice(6, 14)
HIPS = np.array([7, 11])  # hip pitch, left and right
KNEES = np.array([2, 6])  # of the joints
NUM_COORDINATES = 14


class Offsets(NamedTuple):
    """Where parts are joined, which the paper does not give.

    Attributes:
      hip: from the midline to either hip, m.
      trunk: of the trunk's centre over the hips, m.
      heel: of the heel's sphere ahead of the ankle, m; negative is behind.
      toe: likewise.
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
