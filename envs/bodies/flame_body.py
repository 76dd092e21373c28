"""The robot Flame as a tree of links: its coordinates, compiled models, anatomy, and start.

Source and links as in `flame.py`. Sixteen joints are moved by fifteen coordinates: the hip's x, y
and z, yaw, pitch and roll of the torso, the adduction that both legs share, and hip, knee, ankle
and ankle roll of each leg. The torso's angles are Euler's, z-y-x, since each is a sensor and a rule
of the trial; a walker that pitched as far as their singularity would have fallen long before.
"""

import functools
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from mjxwalk.envs import body_file, body_legs, dynamics, floating
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.anatomy import HINGE, LEGS, SLIDE, Anatomy, Sense
from mjxwalk.envs.body_contract import Contract, Joint, Link
from mjxwalk.envs.derived_anatomy import Strength, derive
from mjxwalk.envs.legged_body import Sprung
from mjxwalk.envs.motor import Springs

MODEL_PATH = Path(__file__).with_name("flame.xml")
CORNERS = ("heel_in", "heel_out", "toe_in", "toe_out")
CONTACT_SITES = tuple(f"{corner}_{leg}" for leg in LEGS for corner in CORNERS)
LEG_LENGTH = 0.646  # m, hip to floor with the leg straight; a test holds it to flame.xml
EULER = slice(3, 6)  # of the coordinates; yaw, pitch and roll
PITCH, ROLL, ADDUCTION = 4, 5, 6
HIPS = (7, 11)  # left and right
ANKLE_ROLLS = ("ankle_roll_left", "ankle_roll_right")
TIED = ("adduction_left", "adduction_right")
MOTORS = ("adduction", *(f"{j}_{leg}" for leg in LEGS for j in ("hip", "knee", "ankle")))
_ANGLES = tuple(f"{j}_{leg}" for leg in LEGS for j in ("hip", "knee", "ankle", "ankle_roll"))
_TORSO = ("yaw", "pitch", "roll")
SENSES = (
    Sense("time", "s", "since the start of the trial"),
    Sense(
        "torso", "rad", "yaw, pitch and roll (z-y-x): left, forward and right are positive", _TORSO
    ),
    Sense("torso_rate", "rad/s", "of the torso's angles", _TORSO),
    Sense("adduction", "rad", "of both legs to the torso, legs apart positive"),
    Sense("adduction_rate", "rad/s", "of both legs to the torso, legs apart positive"),
    Sense(
        "angle",
        "rad",
        "of each leg's joints, flexion, dorsiflexion and outer edge up positive",
        _ANGLES,
    ),
    Sense("rate", "rad/s", "of each leg's joints", _ANGLES),
    Sense("contact", "", "whether the left and the right foot touch the ground", LEGS),
    Sense(
        "ankle_x",
        "m",
        "how far the left and the right ankle are ahead of the hips, as it heads",
        LEGS,
    ),
)
# N m and N m s/rad; ours: as the linear controllers are limited to; damping tames random torques
STRENGTH = Strength("torque", (60.0, *(80.0, 60.0, 20.0) * 2), damping=0.2)
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
    motors=("adduction_left", *MOTORS[1:]),
    tied=TIED,
)


def check(text: str) -> None:
    """Returns if a user's XML is a spatial body.

    Raises:
      ValueError: it is not; the message names what, and says what to do.
    """
    body_file.check(text, CONTRACT)
    if leg_length(text) <= 0.0:
        raise ValueError("has its feet's sites above the hips; at all angles zero it must stand")
    model = hinged_model(text).mujoco
    if any(model.qpos_spring[model.joint(name).id] for name in ANKLE_ROLLS):
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


@functools.cache
def springs(text: str, roll: tuple[float, float]) -> Sprung:
    """Returns the passive springs and dampers of the nine coordinates after the root's.

    Args:
      text: a user's XML, or "" for our body.
      roll: stiffness, N m/rad, and damping, N m s/rad, of the ankles' roll.
    """
    found, model = anatomy(text), hinged_model(text).mujoco
    num = found.root.num
    moved = [
        np.flatnonzero(np.array(found.joint_coordinate) == place).tolist()
        for place in range(num, len(found.coordinates))
    ]
    passive = body_legs.springs(model, moved)
    zeros = np.zeros(len(moved), np.float32)
    stiffness, rest, damping = (zeros.copy() for _ in range(3)) if passive is None else passive
    rolls = [found.place(name) - num for name in ANKLE_ROLLS]
    stiffness[rolls], damping[rolls] = roll
    joints = np.flatnonzero(
        (stiffness != 0.0) | (damping != 0.0) | np.isin(range(len(moved)), rolls)
    )
    return Sprung(
        joints.astype(np.int32), Springs(stiffness[joints], rest[joints], damping[joints])
    )


@functools.cache
def anatomy(text: str) -> Anatomy:
    """Returns the anatomy of a body."""
    model = hinged_model(text).mujoco
    return derive(
        model,
        name="Flame",
        motors=MOTORS,
        points=CONTACT_SITES,
        senses=SENSES,
        limits=body_legs.torque_limits_of(
            model, [model.joint(name).id for name in CONTRACT.motors]
        ),
        tied=TIED,
        strength=STRENGTH,
    )


def whole_spec(text: str, stiffness: float, damping: float) -> Any:
    """Returns the `mujoco.MjSpec` with what the engines see to by themselves.

    That is the shared adduction, the springs of the ankles' roll, and motors.
    """
    made = spec(text)
    made.add_equality(
        name="adduction",
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=TIED[1],
        name2=TIED[0],
        data=[0.0, 1.0] + [0.0] * 10,
    )
    for name in ANKLE_ROLLS:
        roll = made.joint(name)
        roll.stiffness[0], roll.damping[0] = stiffness, damping
    for name in () if made.actuators else CONTRACT.motors:
        motor = made.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_motor()
    return made


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
    ankles = np.array([data.body(f"foot_{leg}").xpos[0] for leg in LEGS])
    first = anatomy(text).first_joint
    qpos, qvel = data.qpos[first], data.qvel[first]
    return qpos.astype(np.float32), qvel.astype(np.float32), ankles.astype(np.float32)
