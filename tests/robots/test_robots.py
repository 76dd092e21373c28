"""Tests of the bodies that ship as files: whole, mirrored, on the ground, joined, and licensed."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shipped_bodies import ASYMMETRY, FILES, at_home, compiled, height, mirrored

from mjxwalk import robots
from mjxwalk.cli import main
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.errors import RunError

PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"
DRAWN = 2  # the group of geoms that are seen and touch nothing
GROUND = 1  # the bit of conaffinity by which a geom touches ground of contype 1
# kg; sums of the masses that the makers' files state
MASSES = {
    "h1": 51.437,
    "g1": 33.341142,
    "t1": 31.614357,
    "apollo": 80.897816,
    "op3": 3.14747,
    "berkeley_humanoid": 16.056765,
    "humanoid": 42.11603,
    "walker2d": 23.677137,
}
# Of those whose position motors hold them up, the rest being too soft.
STANDING = ("h1", "op3")


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
    place, mass = ASYMMETRY[name]
    over = np.array([1.0, -1.0, 1.0])
    for body, each in enumerate(names):
        if mirrored(each) == each:
            continue
        other = names.index(mirrored(each))
        assert model.body_mass[body] == pytest.approx(model.body_mass[other], rel=mass)
        for where in (data.xpos, data.xipos):
            assert where[body] == pytest.approx(where[other] * over, abs=place), each
        drawn = [drawn_places(model, data, body_id) for body_id in (body, other)]
        assert drawn[0] == pytest.approx(drawn[1] * over, abs=2e-4), each


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
