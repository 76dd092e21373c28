"""The planar body as a tree of links: ours or a user's, compiled, with its sizes and anatomy."""

import functools
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mjxwalk.envs import body_file, body_legs, dynamics
from mjxwalk.envs._mujoco import compiled
from mjxwalk.envs.anatomy import HINGE, LEGS, SLIDE, Anatomy, Sense
from mjxwalk.envs.body_contract import Contract, Joint, Link
from mjxwalk.envs.derived_anatomy import Strength, derive
from mjxwalk.envs.legged_body import Sprung

MODEL_PATH = Path(__file__).with_name("planar7.xml")
JOINTS = ("hip", "knee", "ankle")
ANGLES = tuple(f"{joint}_{leg}" for leg in LEGS for joint in JOINTS)
CONTACT_SITES = tuple(f"{point}_{leg}" for leg in LEGS for point in ("heel", "toe"))
LEG_LENGTH = 0.9275  # m, hip to floor with the leg straight; a test holds it to planar7.xml
SOLE_DEPTH = 0.068  # m, ankle to sole; a test holds it to planar7.xml
SENSES = (
    Sense("time", "s", "since the start of the trial; the controller blends its weights by it"),
    Sense("pitch", "rad", "of the upper body, forward lean positive"),
    Sense("pitch_rate", "rad/s", "of the upper body, forward lean positive"),
    Sense("angle", "rad", "of each leg's joints, flexion and dorsiflexion positive", ANGLES),
    Sense("rate", "rad/s", "of each leg's joints, flexion and dorsiflexion positive", ANGLES),
    Sense("contact", "", "whether heel or toe of left and right foot touch the ground", LEGS),
    Sense("ankle_x", "m", "how far the left and the right ankle are ahead of the hip, level", LEGS),
)
# N m and N m s/rad; ours: as the linear controllers are limited to; damping tames random torques
STRENGTH = Strength("torque", (300.0,) * 6, damping=2.0)


def _leg(side: str) -> tuple[Link, ...]:
    return (
        Link(f"thigh_{side}", "torso", (Joint(f"hip_{side}", HINGE, (0, -1, 0)),), hangs=False),
        Link(
            f"shank_{side}",
            f"thigh_{side}",
            (Joint(f"knee_{side}", HINGE, (0, 1, 0)),),
            hangs=True,
        ),
        Link(
            f"foot_{side}",
            f"shank_{side}",
            (Joint(f"ankle_{side}", HINGE, (0, -1, 0)),),
            hangs=True,
        ),
    )


ROOT = (
    Joint("root_x", SLIDE, (1, 0, 0)),
    Joint("root_z", SLIDE, (0, 0, 1)),
    Joint("root_pitch", HINGE, (0, 1, 0)),
)
CONTRACT = Contract(
    kind="planar",
    links=(Link("torso", "world", ROOT), *(link for leg in LEGS for link in _leg(leg))),
    sites=tuple((site, f"foot_{site.rpartition('_')[2]}") for site in CONTACT_SITES),
    motors=ANGLES,
)


class Masses(NamedTuple):
    """Of the upper body and of one leg's links, kg."""

    torso: float
    thigh: float
    shank: float
    foot: float


class Sizes(NamedTuple):
    """Lengths that the rules of a trial hang on.

    Attributes:
      leg: hip to floor with the leg straight, m.
      sole: ankle to sole, m.
      toe: how far the toe is ahead of the ankle, m.
    """

    leg: float
    sole: float
    toe: float


def check(text: str) -> None:
    """Returns if a user's XML is a planar body.

    Raises:
      ValueError: it is not; the message names what, and says what to do.
    """
    body_file.check(text, CONTRACT)
    _, sole, _ = sizes(text)
    model = _file_model(text)
    for leg in LEGS:
        heel, toe = (model.site(f"{end}_{leg}").pos for end in ("heel", "toe"))
        if abs(heel[2] - toe[2]) > body_file.CLOSE or not heel[0] < toe[0] or sole <= 0.0:
            raise ValueError(
                f"heel_{leg} lies at {heel[0]:.4g} {heel[2]:.4g} and toe_{leg} at {toe[0]:.4g} "
                f"{toe[2]:.4g} (x, z); with the leg straight both must be at one height, below the "
                "ankle, and the toe ahead of the heel"
            )


def check_start(text: str, hip_angle: float) -> None:
    """Returns if a body can start with its legs that far apart, soles level.

    Raises:
      ValueError: a joint's range is too small.
    """
    model = _file_model(text)
    for name, angle in (("hip_left", hip_angle), ("ankle_left", -hip_angle)):
        lower, upper = model.joint(name).range
        if not lower <= -abs(angle) <= abs(angle) <= upper:
            raise ValueError(
                f"joint {name} has the range {lower:.4g} to {upper:.4g} rad, and the start needs "
                f"{-abs(angle):.4g} to {abs(angle):.4g}; widen it, or set env.start_hip_angle"
            )


@functools.cache
def sizes(text: str) -> Sizes:
    """Returns a body's lengths; of ours for the text ""."""
    model = _file_model(text)
    sole = -float(model.site("heel_left").pos[2])
    links = -float(model.body("shank_left").pos[2] + model.body("foot_left").pos[2])
    # Rounded, so that lengths which are the same but for the sums of their parts are the same.
    return Sizes(
        *(round(each, 9) for each in (links + sole, sole, float(model.site("toe_left").pos[0])))
    )


def masses(text: str) -> Masses:
    """Returns the masses that a body's file has."""
    model = _file_model(text)
    names = ("torso", "thigh_left", "shank_left", "foot_left")
    return Masses(*(float(model.body(name).mass[0]) for name in names))


def spec(text: str) -> Any:
    """Returns the `mujoco.MjSpec` of a user's XML, or of ours for the text ""."""
    return body_file.read(text or MODEL_PATH.read_text(encoding="utf-8"))


@functools.cache
def _file_model(text: str) -> Any:
    return compiled(spec(text))


def with_masses(text: str, masses: Masses) -> Any:
    """Returns the `mujoco.MjSpec` with the inertia of each link scaled with its mass."""
    made, found = spec(text), _file_model(text)
    due = {"torso": masses.torso}
    for leg in LEGS:
        due |= {f"{name}_{leg}": getattr(masses, name) for name in ("thigh", "shank", "foot")}
    for name, mass in due.items():
        body, as_found = made.body(name), found.body(name)
        body.ipos, body.iquat = np.array(as_found.ipos), np.array(as_found.iquat)
        body.inertia = np.array(as_found.inertia) * (mass / as_found.mass[0])
        body.mass = mass
        body.explicitinertial = True
    return made


@functools.cache
def compile_body(text: str, masses: Masses) -> dynamics.Model:
    """Returns the model of a body with these masses."""
    return dynamics.compile_model(with_masses(text, masses))


@functools.cache
def springs(text: str) -> Sprung | None:
    """Returns the passive springs and dampers of the six joints."""
    found = body_legs.springs(_file_model(text), [[joint] for joint in range(3, 9)])
    return None if found is None else Sprung(np.arange(6, dtype=np.int32), found)


@functools.cache
def anatomy(text: str) -> Anatomy:
    """Returns the anatomy of a body."""
    model = _file_model(text)
    joints = [model.joint(name).id for name in CONTRACT.motors]
    return derive(
        model,
        name="Planar7",
        motors=CONTRACT.motors,
        points=CONTACT_SITES,
        senses=SENSES,
        limits=body_legs.torque_limits_of(model, joints),
        strength=STRENGTH,
    )
