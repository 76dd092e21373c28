"""Tests that the bodies with Gymnasium's measures have them."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from shipped_bodies import at_home, compiled

from mjxwalk.envs._mujoco import mujoco

GYMNASIUM = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"


NAMES_OF_WALKER2D = {
    "torso": "torso",
    **{f"{part}_left": f"{old}_left" for part, old in (("thigh", "thigh"), ("foot", "foot"))},
    **{f"{part}_right": part for part in ("thigh", "foot")},
    "shank_left": "leg_left",
    "shank_right": "leg",
}


def test_walker2d_has_the_measures_of_gymnasiums() -> None:
    ours, theirs = (
        compiled("walker2d"),
        mujoco.MjModel.from_xml_path(f"{GYMNASIUM}/walker2d_v5.xml"),
    )
    angles = np.array([-0.3, -0.4, -0.9, 0.2, -0.7, -1.3, -0.4])  # pitch, then left, then right
    data = mujoco.MjData(ours)
    data.qpos[2:] = angles
    other = mujoco.MjData(theirs)
    other.qpos[2:] = angles[[0, 4, 5, 6, 1, 2, 3]]  # right, then left
    same_motion(ours, data, theirs, other, NAMES_OF_WALKER2D)
    for joint, old in (("hip", "thigh"), ("knee", "leg"), ("ankle", "foot")):
        for side, suffix in (("left", "_left"), ("right", "")):
            same_joint(ours, f"{joint}_{side}", theirs, f"{old}{suffix}_joint")


NAMES_OF_HUMANOID = {
    "torso": "torso",
    "waist": "lwaist",
    "pelvis": "pelvis",
    **{
        f"{part}_{side}": f"{side}_{old}"
        for side in ("left", "right")
        for part, old in (
            ("thigh", "thigh"),
            ("shank", "shin"),
            ("foot", "foot"),
            ("upper_arm", "upper_arm"),
            ("lower_arm", "lower_arm"),
        )
    },
}
JOINTS_OF_HUMANOID = {
    "waist_yaw": "abdomen_z",
    "waist_pitch": "abdomen_y",
    "waist_roll": "abdomen_x",
    **{
        f"{joint}_{side}": f"{side}_{old}"
        for side in ("left", "right")
        for joint, old in (
            ("hip_roll", "hip_x"),
            ("hip_yaw", "hip_z"),
            ("hip_pitch", "hip_y"),
            ("knee", "knee"),
            ("shoulder1", "shoulder1"),
            ("shoulder2", "shoulder2"),
            ("elbow", "elbow"),
        )
    },
}
LIKE_THE_RIGHT = ("hip_pitch_left", "knee_left")  # whose armature and spring differ there


def test_humanoid_has_the_measures_of_gymnasiums() -> None:
    ours, theirs = compiled("humanoid"), mujoco.MjModel.from_xml_path(f"{GYMNASIUM}/humanoid.xml")
    data, other = mujoco.MjData(ours), mujoco.MjData(theirs)
    draw = np.random.default_rng(3)
    for name, old in JOINTS_OF_HUMANOID.items():
        lower, upper = ours.joint(name).range
        angle = draw.uniform(lower, upper)
        data.joint(name).qpos[:] = other.joint(old).qpos[:] = angle
    same_motion(ours, data, theirs, other, NAMES_OF_HUMANOID)
    for name, old in JOINTS_OF_HUMANOID.items():
        like = old.replace("left", "right") if name in LIKE_THE_RIGHT else old
        same_joint(ours, name, theirs, like)


def test_humanoid_stands_on_gymnasiums_spheres_and_on_toes() -> None:
    ours, theirs = compiled("humanoid"), mujoco.MjModel.from_xml_path(f"{GYMNASIUM}/humanoid.xml")
    for side in ("left", "right"):
        heel, sphere = ours.geom(f"heel_{side}"), theirs.geom(f"{side}_foot")
        assert heel.size[0] == pytest.approx(sphere.size[0])
        assert heel.pos == pytest.approx(ours.body(f"foot_{side}").ipos)
    data = at_home(ours)
    touching = np.flatnonzero(ours.geom_conaffinity & 1)
    low = data.geom_xpos[touching, 2] - ours.geom_size[touching, 0]
    assert len(touching) == 6
    assert low == pytest.approx(np.zeros(6), abs=1e-4)


def same_motion(ours: Any, data: Any, theirs: Any, other: Any, names: dict[str, str]) -> None:
    """Asserts that two models in one posture have the same masses, inertias and places."""
    for model, each in ((ours, data), (theirs, other)):
        mujoco.mj_kinematics(model, each)
    first = next(iter(names.items()))
    shift = other.body(first[1]).xipos - data.body(first[0]).xipos
    for name, old in names.items():
        a, b = ours.body(name).id, theirs.body(old).id
        assert ours.body_mass[a] == pytest.approx(theirs.body_mass[b], rel=1e-6), name
        assert data.xipos[a] + shift == pytest.approx(other.xipos[b], abs=1e-6), name
        assert world_inertia(ours, data, a) == pytest.approx(
            world_inertia(theirs, other, b), abs=1e-7
        ), name


def world_inertia(model: Any, data: Any, body: int) -> Any:
    """Returns a body's inertia about its centre of mass in the world's axes, kg m^2."""
    turned = data.ximat[body].reshape(3, 3)
    return turned @ np.diag(model.body_inertia[body]) @ turned.T


def same_joint(ours: Any, name: str, theirs: Any, old: str) -> None:
    """Asserts that two joints have the same range, damping, armature, stiffness and gear."""
    a, b = ours.joint(name), theirs.joint(old)
    for field in ("range", "damping", "armature", "stiffness", "frictionloss"):
        assert getattr(a, field) == pytest.approx(getattr(b, field)), (name, field)
    motors = [
        int(np.flatnonzero(model.actuator_trnid[:, 0] == joint.id)[0])
        for model, joint in ((ours, a), (theirs, b))
    ]
    assert ours.actuator_gear[motors[0]] == pytest.approx(theirs.actuator_gear[motors[1]])
    assert ours.actuator_ctrlrange[motors[0]] == pytest.approx(theirs.actuator_ctrlrange[motors[1]])
