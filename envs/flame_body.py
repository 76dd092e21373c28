"""The robot Flame as a tree of links: its coordinates, compiled models, and how it starts.

Source and links as in `flame.py`. Sixteen joints are moved by fifteen coordinates: the hip's x, y
and z, yaw, pitch and roll of the torso, the adduction that both legs share, and hip, knee, ankle
and ankle roll of each leg. The torso's angles are Euler's, z-y-x, since each is a sensor and a rule
of the trial; a walker that pitched as far as their singularity would have fallen long before.
"""

import functools
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import body_file, body_legs, dynamics, floating
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.body_contract import HINGE, SLIDE, Contract, Joint, Link
from mjxwalk.envs.motor import Limits, Springs

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


def _leg(side: str, out: int) -> tuple[Link, ...]:
    """Returns the links of a leg, its outer side towards y times `out`."""
    ankle = Joint(f"ankle_{side}", HINGE, (0, -1, 0))
    roll = Joint(f"ankle_roll_{side}", HINGE, (out, 0, 0))
    return (
        Link(f"hip_link_{side}", "torso", (Joint(f"adduction_{side}", HINGE, (out, 0, 0)),)),
        Link(f"thigh_{side}", f"hip_link_{side}", (Joint(f"hip_{side}", HINGE, (0, -1, 0)),)),
        Link(f"shank_{side}", f"thigh_{side}", (Joint(f"knee_{side}", HINGE, (0, 1, 0)),)),
        Link(f"foot_{side}", f"shank_{side}", (ankle, roll)),
    )


ROOT = (
    Joint("root_x", SLIDE, (1, 0, 0)),
    Joint("root_y", SLIDE, (0, 1, 0)),
    Joint("root_z", SLIDE, (0, 0, 1)),
    Joint("root_yaw", HINGE, (0, 0, 1)),
    Joint("root_pitch", HINGE, (0, 1, 0)),
    Joint("root_roll", HINGE, (1, 0, 0)),
)
CONTRACT = Contract(
    kind="spatial",
    links=(Link("torso", "world", ROOT), *_leg("left", 1), *_leg("right", -1)),
    sites=tuple((site, f"foot_{site.rpartition('_')[2]}") for site in CONTACT_SITES),
    motors=("adduction_left", *(f"{j}_{leg}" for leg in LEGS for j in ("hip", "knee", "ankle"))),
    tied=("adduction_left", "adduction_right"),
)


def check(text: str) -> None:
    """Returns if a user's XML is a spatial body.

    Raises:
      ValueError: it is not; the message names what, and says what to do.
    """
    body_file.check(text, CONTRACT)
    if leg_length(text) <= 0.0:
        raise ValueError("has its feet's sites above the hips; at all angles zero it must stand")
    if np.any(hinged_model(text).mujoco.qpos_spring[FIRST_JOINT[ANKLE_ROLLS]]):
        raise ValueError("joint ankle_roll_left has springref, and must rest at 0; remove it")


def spec(text: str) -> Any:
    """Returns the `mujoco.MjSpec` of a user's XML, or of ours for the text ""."""
    made = body_file.read(text or MODEL_PATH.read_text(encoding="utf-8"))
    for equality in list(made.equalities):
        made.delete(equality)  # the adductions', which coordinates see to
    return made


@functools.cache
def leg_length(text: str) -> float:
    """Returns hip to floor with the leg straight, m; of our body for the text ""."""
    model = hinged_model(text).mujoco
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    # Rounded, so that lengths which are the same but for the sums of their parts are the same.
    return round(-min(float(data.site(name).xpos[2]) for name in CONTACT_SITES), 9)


def ankle_roll(text: str) -> tuple[float, float]:
    """Returns stiffness and damping that a file gives the ankles' roll."""
    model = hinged_model(text).mujoco
    joint = model.joint("ankle_roll_left").id
    return float(model.jnt_stiffness[joint]), float(model.dof_damping[joint])


def springs(text: str) -> Springs | None:
    """Returns the passive springs and dampers of the nine coordinates but the ankles' roll."""
    model = hinged_model(text).mujoco
    joints = [np.flatnonzero(COORDINATE == c).tolist() for c in range(6, 15)]
    found = body_legs.springs(model, joints)
    if found is None:
        return None
    kept = np.ones(9, np.float32)
    kept[ANKLE_ROLLS - JOINTS.start] = 0.0
    if not (kept * found.stiffness).any() and not (kept * found.damping).any():
        return None
    return Springs(kept * found.stiffness, found.rest, kept * found.damping)


def limits(text: str) -> Limits | None:
    """Returns the limits of the seven motors."""
    model = hinged_model(text).mujoco
    return body_legs.limits(model, FIRST_JOINT[ACTUATED].tolist())


def on_joints(values: Float[Array, "9"]) -> Float[Array, "16"]:
    """Returns the nine joints' values for the model's sixteen, the adduction's once."""
    return jnp.concatenate([jnp.zeros(6), values[:5], jnp.zeros(1), values[5:]])


def joint_ranges(text: str) -> tuple[Float[np.ndarray, "9"], Float[np.ndarray, "9"]]:
    """Returns where the soft stops of the nine joints begin, rad."""
    lower, upper = hinged_model(text).mujoco.jnt_range.astype(np.float32).T
    return lower[FIRST_JOINT[JOINTS]], upper[FIRST_JOINT[JOINTS]]


@functools.cache
def hinged_model(text: str) -> dynamics.Model:
    """Returns the compiled body with a hinge for each of the torso's angles."""
    return dynamics.compile_model(spec(text))


@functools.cache
def floating_model(text: str) -> dynamics.Model:
    """Returns the compiled body with a free root."""
    return dynamics.compile_model(floating.freed(spec(text), "torso"))


@functools.cache
def start(
    text: str,
    depth: float,
) -> tuple[Float[np.ndarray, "15"], Float[np.ndarray, "15"], Float[np.ndarray, "2"]]:
    """Returns qpos, qvel and `ankle_x` of the start, the right sole that far below height zero."""
    model = hinged_model(text).mujoco
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
