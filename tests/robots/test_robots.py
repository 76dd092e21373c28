"""Tests of the bodies that ship as files: whole, mirrored, on the ground, joined, and licensed."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from mjxwalk import robots
from mjxwalk.cli import main
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.errors import RunError

FILES = sorted(path.stem for path in robots.FOLDER.glob("*.xml"))
PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"
GYMNASIUM = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
DRAWN = 2  # the group of geoms that are seen and touch nothing
GROUND = 1  # the bit of conaffinity by which a geom touches ground of contype 1
# kg; sums of the masses that the makers' files state
MASSES = {"h1": 51.437, "g1": 33.341142, "walker2d": 23.677137}
ASYMMETRY = {"h1": 1e-6, "g1": 1e-4, "walker2d": 1e-9}  # m and kg/kg; the makers' own
# Of those whose position motors hold them up, the rest being too soft at the ankles.
STANDING = ("h1",)
SIDES = [("left", "right"), ("Left", "Right")]


def compiled(name: str, floor: bool = False) -> Any:
    """Returns a body's `mujoco.MjModel`, on a floor if asked."""
    spec = mujoco.MjSpec.from_file(str(robots.path(name)))
    if floor:
        plane = mujoco.mjtGeom.mjGEOM_PLANE
        spec.worldbody.add_geom(name="floor", type=plane, size=[0, 0, 1], conaffinity=0)
    return spec.compile()


def at_home(model: Any) -> Any:
    """Returns the data of a body in its keyframe `home`."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    mujoco.mj_forward(model, data)
    return data


def mirrored(name: str) -> str:
    """Returns the name of the same part on the other side; of a part in the middle, its own."""
    for left, right in SIDES:
        if left in name:
            return name.replace(left, right)
    return name


def height(model: Any, data: Any, geom: int) -> float:
    """Returns how far a geom is above a floor at 0, m."""
    where = np.zeros(6)
    return float(mujoco.mj_geomDistance(model, data, geom, model.geom("floor").id, 5.0, where))


def test_every_file_is_named_and_every_name_has_a_file() -> None:
    assert [name for name in FILES if name not in robots.names()] == []
    assert all(robots.path(name).is_file() for name in robots.names())
    assert robots.text("h1").startswith("<!-- Unitree H1")


def test_a_wrong_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(RunError, match="there is no body walker; did you mean walker2d"):
        robots.path("walker")


def test_names_are_found_without_jax_and_without_mujoco() -> None:
    code = (
        "import sys; from mjxwalk import robots; assert all(map(robots.path, robots.names()))\n"
        "assert not {'jax', 'mujoco', 'numpy'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_list_shows_every_body(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list"]) == 0
    shown = capsys.readouterr().out.partition("Bodies\n")[2].partition("\n\n")[0]
    assert [line.split()[0] for line in shown.splitlines()] == robots.names()


@pytest.mark.parametrize("name", FILES)
def test_a_file_says_what_it_derives_from_and_its_licence_lies_beside_it(name: str) -> None:
    path = robots.licence_path(name)
    assert path is not None
    licence = path.read_text()
    phrases = {
        "Apache-2.0": "Apache License",
        "BSD-3-Clause": "Redistribution and use in source",
        "MIT": "Permission is hereby granted, free of charge",
    }
    stated = robots.BODIES[name].licence.split(" AND ")
    assert all(phrases[each] in licence for each in stated)
    head = robots.text(name).partition("-->")[0]
    assert all(each in head for each in stated)
    assert path.name in head


def test_the_package_states_every_licence_of_a_body() -> None:
    project = tomllib.loads(PYPROJECT.read_text())["project"]
    stated = project["license"].split(" AND ")
    for body in robots.BODIES.values():
        assert set(body.licence.split(" AND ")) <= set(stated)
    listed = {
        path.name for each in project["license-files"] for path in PYPROJECT.parent.glob(each)
    }
    assert listed == {"LICENSE", *(f"{name}.LICENSE" for name in FILES)}


@pytest.mark.parametrize("name", FILES)
def test_a_file_refers_to_no_other_and_has_no_floor(name: str) -> None:
    text = robots.text(name)
    assert not re.search(r'file=|<include|<mesh|<texture|"plane"', text)
    model = compiled(name)
    assert not (model.geom_bodyid == 0).any()
    assert model.body_mass.sum() == pytest.approx(MASSES[name], abs=1e-6)


@pytest.mark.parametrize("name", FILES)
def test_left_and_right_are_mirrored(name: str) -> None:
    model = compiled(name)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    names = [model.body(i).name for i in range(model.nbody)]
    assert sum(mirrored(each) != each for each in names) >= 3
    over = np.array([1.0, -1.0, 1.0])
    for body, each in enumerate(names):
        if mirrored(each) == each:
            continue
        other = names.index(mirrored(each))
        assert model.body_mass[body] == pytest.approx(model.body_mass[other], rel=ASYMMETRY[name])
        for where in (data.xpos, data.xipos):
            assert where[body] == pytest.approx(where[other] * over, abs=ASYMMETRY[name]), each
        drawn = [drawn_places(model, data, body_id) for body_id in (body, other)]
        assert drawn[0] == pytest.approx(drawn[1] * over, abs=1e-4 + ASYMMETRY[name]), each


def drawn_places(model: Any, data: Any, body: int) -> Any:
    """Returns where what is drawn of a body is, m [geom, axis], in the file's order."""
    geoms = (model.geom_bodyid == body) & (model.geom_group == DRAWN)
    return data.geom_xpos[geoms]


@pytest.mark.parametrize("name", FILES)
def test_at_home_the_soles_touch_the_ground_and_nothing_is_below_it(name: str) -> None:
    model = compiled(name, floor=True)
    data = at_home(model)
    geoms = [g for g in range(model.ngeom) if g != model.geom("floor").id]
    touching = [height(model, data, g) for g in geoms if model.geom_conaffinity[g] & GROUND]
    assert min(touching) == pytest.approx(0.0, abs=1e-4)
    drawn = [height(model, data, g) for g in geoms if model.geom_group[g] == DRAWN]
    assert min(drawn) == pytest.approx(0.0, abs=2e-3)


@pytest.mark.parametrize("name", FILES)
def test_what_is_drawn_hangs_together_and_collides_with_nothing(name: str) -> None:
    model = compiled(name)
    data = at_home(model)
    geoms = np.flatnonzero(model.geom_group == DRAWN)
    assert not model.geom_contype[geoms].any() and not model.geom_conaffinity[geoms].any()
    reached, left = {int(geoms[0])}, {int(geom) for geom in geoms[1:]}
    while True:
        near = {g for g in left if any(touch(model, data, g, other) for other in reached)}
        if not near:
            break
        reached, left = reached | near, left - near
    assert [model.body(model.geom_bodyid[geom]).name for geom in left] == []


def touch(model: Any, data: Any, geom: int, other: int) -> bool:
    """Returns whether two geoms overlap or come within a centimetre of each other."""
    return mujoco.mj_geomDistance(model, data, geom, other, 1.0, np.zeros(6)) < 0.01


@pytest.mark.parametrize("name", FILES)
def test_motors_are_bounded_and_hold_the_angles_of_home(name: str) -> None:
    model = compiled(name)
    data = at_home(model)
    assert model.nu == len(set(model.actuator_trnid[:, 0]))
    assert model.actuator_ctrllimited.all()
    if not model.actuator_biasprm.any():  # torques
        return
    joints = model.actuator_trnid[:, 0]
    assert data.ctrl == pytest.approx(data.qpos[model.jnt_qposadr[joints]])
    bounded = model.actuator_forcelimited.astype(bool) | model.jnt_actfrclimited[joints]
    assert bounded.all()


@pytest.mark.parametrize("name", STANDING)
def test_position_motors_hold_a_body_up_for_a_second(name: str) -> None:
    model = compiled(name, floor=True)
    data = at_home(model)
    before = float(data.subtree_com[1][2])
    mujoco.mj_step(model, data, round(1.0 / model.opt.timestep))
    assert float(data.subtree_com[1][2]) > 0.95 * before
    assert data.xmat[1].reshape(3, 3)[2, 2] > np.cos(0.1)


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
