"""The robot Flame as a tree of links: its coordinates, compiled models, and how it starts.

Source and links as in `flame.py`. Sixteen joints are moved by fifteen coordinates: the hip's x, y
and z, yaw, pitch and roll of the torso, the adduction that both legs share, and hip, knee, ankle
and ankle roll of each leg. The torso's angles are Euler's, z-y-x, since each is a sensor and a rule
of the trial; a walker that pitched as far as their singularity would have fallen long before.
"""

import functools
from pathlib import Path

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import dynamics, floating
from mjxwalk.envs._mujoco import mujoco

MODEL_PATH = Path(__file__).with_name("flame.xml")
LEGS = ("left", "right")
FEET = tuple(f"foot_{leg}" for leg in LEGS)
CORNERS = ("heel_in", "heel_out", "toe_in", "toe_out")
CONTACT_SITES = tuple(f"{corner}_{leg}" for leg in LEGS for corner in CORNERS)
LEG_LENGTH = 0.646  # m, hip to floor with the leg straight; a test holds it to flame.xml
GRAVITY = 9.81  # m/s^2, as in MuJoCo
# ours: beyond these speeds a simulation has diverged; a foot that spins free reaches 100 rad/s.
MAX_SPEED = np.array([50.0] * 3 + [1000.0] * 12, np.float32)  # m/s, rad/s
EULER = slice(3, 6)  # of the coordinates; yaw, pitch and roll
PITCH, ROLL, ADDUCTION = 4, 5, 6
HIPS = (7, 11)  # left and right
ACTUATED = np.array([6, 7, 8, 9, 11, 12, 13])
ANKLE_ROLLS = np.array([10, 14])
JOINTS = slice(6, 15)
# Which coordinate moves each of the sixteen joints: only the adduction moves two.
COORDINATE = np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 6, 11, 12, 13, 14])
FIRST_JOINT = np.unique(COORDINATE, return_index=True)[1]
COUPLING = np.eye(15, dtype=np.float32)[COORDINATE]
# ours, as are all numbers of the start: the paper says only that the swing foot is in the air and
# the angle between the legs grows. The right leg stands upright, the left one swings forward.
START_ANGLE = {
    "root_pitch": 0.05,
    "root_roll": 0.03,
    "adduction": 0.05,
    "hip_left": 0.40,
    "knee_left": 0.60,
    "ankle_left": 0.25,  # level
    "hip_right": 0.05,
    "ankle_roll_right": -0.02,  # level
}  # rad
START_RATE = {"hip_left": 1.5, "hip_right": -1.0, "ankle_right": 1.0}  # rad/s


def on_joints(values: Float[Array, "9"]) -> Float[Array, "16"]:
    """Returns the nine joints' values for the model's sixteen, the adduction's once."""
    return jnp.concatenate([jnp.zeros(6), values[:5], jnp.zeros(1), values[5:]])


def joint_ranges() -> tuple[Float[np.ndarray, "9"], Float[np.ndarray, "9"]]:
    """Returns where the soft stops of the nine joints begin, rad."""
    lower, upper = hinged_model().mujoco.jnt_range.astype(np.float32).T
    return lower[FIRST_JOINT[JOINTS]], upper[FIRST_JOINT[JOINTS]]


@functools.cache
def hinged_model() -> dynamics.Model:
    """Returns the compiled body with a hinge for each of the torso's angles."""
    return dynamics.compile_model(mujoco.MjSpec.from_file(str(MODEL_PATH)))


@functools.cache
def floating_model() -> dynamics.Model:
    """Returns the compiled body with a free root."""
    spec = mujoco.MjSpec.from_file(str(MODEL_PATH))
    return dynamics.compile_model(floating.freed(spec, "torso"))


@functools.cache
def start(
    depth: float,
) -> tuple[Float[np.ndarray, "15"], Float[np.ndarray, "15"], Float[np.ndarray, "2"]]:
    """Returns qpos, qvel and `ankle_x` of the start, the right sole that far below height zero."""
    model = hinged_model().mujoco
    data = mujoco.MjData(model)
    for values, settings in ((data.qpos, START_ANGLE), (data.qvel, START_RATE)):
        for name, value in settings.items():
            for joint in (name,) if name != "adduction" else (f"{name}_left", f"{name}_right"):
                values[model.joint(joint).id] = value
    mujoco.mj_forward(model, data)
    standing = [model.site(name).id for name in CONTACT_SITES[4:]]
    data.qpos[2] = -data.site_xpos[standing, 2].mean() - depth
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jacBody(model, data, jacobian, None, model.body("foot_right").id)
    data.qvel[:3] = -jacobian @ data.qvel  # its ankle stands still
    ankles = np.array([data.body(foot).xpos[0] for foot in FEET])
    qpos, qvel = data.qpos[FIRST_JOINT], data.qvel[FIRST_JOINT]
    return qpos.astype(np.float32), qvel.astype(np.float32), ankles.astype(np.float32)
