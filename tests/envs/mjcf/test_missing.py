"""Tests of what a file names and does not have."""

import re
from pathlib import Path

import numpy as np
import pytest

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import reader

ROBOT = """<mujoco>
  <worldbody>{world}
    <body name="trunk" pos="0 0 0.5"><freejoint/><geom size="0.1" contype="0" conaffinity="0"/>
      <body name="leg"><joint name="hip" axis="0 1 0"/>
        <geom name="foot" type="capsule" size="0.03" fromto="0 0 0 0 0 -0.4" contype="0"
          conaffinity="0"/>
      </body>
    </body>
  </worldbody>
  <asset>{asset}</asset>
  <contact>
{pairs}
  </contact>
  <actuator><motor joint="hip"/></actuator>
  <keyframe>{keys}</keyframe>
</mujoco>
"""


def robot(tmp_path: Path, **parts: str) -> reader.BodyFile:
    """Returns the robot with some parts, read from a file."""
    given = {"world": "", "asset": "", "pairs": "", "keys": "", **parts}
    path = tmp_path / "robot.xml"
    path.write_text(ROBOT.format(**given))
    return reader.read(path)


def test_a_floor_that_pairs_collide_with_is_laid(tmp_path: Path) -> None:
    pair = '<pair name="floor_foot" geom1="foot" geom2="floor" friction="0.6 0.6 0.1 0.1 0.1"/>'
    found = robot(tmp_path, pairs=pair)
    model = mujoco.MjModel.from_xml_string(found.text)
    assert model.npair == 1 and model.pair_friction[0][0] == 0.6
    assert model.geom("floor").type[0] == mujoco.mjtGeom.mjGEOM_PLANE
    assert any("no geom floor" in note for note in found.notes)
    data = mujoco.MjData(model)
    data.qpos[2] = 0.42
    mujoco.mj_forward(model, data)
    assert data.ncon > 0  # the foot touches the floor, and nothing else can


def test_a_pair_of_another_thing_is_left_out_with_its_line(tmp_path: Path) -> None:
    found = robot(tmp_path, pairs='<pair name="ball" geom1="foot" geom2="ball"/>')
    assert mujoco.MjModel.from_xml_string(found.text).npair == 0
    line = ROBOT.splitlines().index("{pairs}") + 1
    assert f"Line {line}: the pair ball is left out; the file has no geom ball." in found.notes


def test_a_height_field_becomes_a_plane_of_the_same_name_though_its_file_is_missing(
    tmp_path: Path,
) -> None:
    found = robot(
        tmp_path,
        world='<geom name="hills" type="hfield" hfield="hills" pos="0 0 0.1" friction="0.7 0 0"/>',
        asset='<hfield name="hills" file="nowhere.png" size="5 5 1 0.1"/>',
    )
    model = mujoco.MjModel.from_xml_string(found.text)
    geom = model.geom("hills")
    assert geom.type[0] == mujoco.mjtGeom.mjGEOM_PLANE
    np.testing.assert_allclose([*geom.pos, geom.friction[0]], [0, 0, 0.1, 0.7])
    assert any("height field hills is replaced by a level plane" in note for note in found.notes)


def test_a_keyframe_of_a_scene_is_left_out(tmp_path: Path) -> None:
    found = robot(tmp_path, keys='<key name="with_ball" qpos="1 2 3 4 5 6 7 8 9 10 11 12 13 14"/>')
    assert mujoco.MjModel.from_xml_string(found.text).nkey == 0
    assert any(
        re.search("keyframe with_ball is left out; it has 14 coordinates, and the body 8", note)
        for note in found.notes
    )


def test_what_of_the_world_is_no_floor_is_left_out(tmp_path: Path) -> None:
    world = (
        '<geom name="floor" type="plane" size="1 1 1"/><geom name="box" type="box" size="1 1 1"/>'
    )
    found = robot(tmp_path, world=world)
    assert mujoco.MjModel.from_xml_string(found.text).ngeom == 3
    assert "Geom box stands beside the robot; it is left out." in found.notes


@pytest.mark.parametrize("name", ["shell.dae", "shell.stl"])
def test_a_mesh_that_cannot_be_opened_is_not_drawn(tmp_path: Path, name: str) -> None:
    (tmp_path / "shell.dae").write_text("<COLLADA/>")
    world = '<geom type="mesh" mesh="shell" contype="0" conaffinity="0"/>'
    found = robot(tmp_path, world="", asset=f'<mesh name="shell" file="{name}"/>', pairs="")
    assert mujoco.MjModel.from_xml_string(found.text).nmesh == 0
    body = ROBOT.replace("<freejoint/>", f"<freejoint/>{world}")
    path = tmp_path / "drawn.xml"
    path.write_text(
        body.format(world="", asset=f'<mesh name="shell" file="{name}"/>', pairs="", keys="")
        .replace('contype="0" conaffinity="0"/>', 'mass="0" contype="0" conaffinity="0"/>')
        .replace('<geom size="0.1" mass="0"', '<geom size="0.1"')
    )
    notes = reader.read(path).notes
    kind = "missing" if name.endswith("stl") else "of a kind that MuJoCo does not open"
    assert any(f"{name} is {kind}; body trunk is drawn without it." in note for note in notes)
