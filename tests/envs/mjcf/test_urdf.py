"""Tests of URDF files: what MuJoCo does not take from them, or takes otherwise."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mjxwalk.envs import MjcfEnv
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import reader

PACKAGE = Path(__file__).parent / "files/biped_description"
URDF = PACKAGE / "urdf/biped.urdf"


def model_of(path: Path) -> Any:
    return mujoco.MjModel.from_xml_string(reader.read(path).text)


def test_the_root_is_free() -> None:
    model = model_of(URDF)
    assert model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE and model.nv == 6 + 6
    notes = reader.read(URDF).notes
    assert "The link pelvis is given a free joint, as a URDF has none." in notes


def test_motors_have_the_limits_of_efforts_else_a_share_of_weight_times_height() -> None:
    found = reader.read(URDF)
    motors = {motor.name: motor for motor in MjcfEnv.of(found.text).anatomy.motors}
    assert motors["hip_left"].highest == 60.0
    mass = float(np.sum(model_of(URDF).body_mass))
    # From the pelvis to the sole: the links, and half of the sole below its place.
    height = 0.05 + 0.3 + 0.3 + 0.04 + 0.01
    assert np.isclose(motors["ankle_left"].highest, 0.5 * 9.81 * mass * height, rtol=0.02)
    assert any("4 of them up to the limits of their joints" in note for note in found.notes)


def test_meshes_of_packages_are_found_and_others_named() -> None:
    model = model_of(URDF)
    assert model.nmesh == 2  # the pelvis has the sole's, larger
    assert any(
        "shank.dae is missing; bodies shank_left and shank_right" in note
        for note in reader.read(URDF).notes
    )


def test_visual_shapes_are_drawn_and_touch_nothing() -> None:
    model = model_of(URDF)
    thigh = int(model.body("thigh_left").geomadr[0])
    assert model.geom_type[thigh] == mujoco.mjtGeom.mjGEOM_CYLINDER
    assert not model.geom_contype[thigh] and not model.geom_conaffinity[thigh]


def test_dry_friction_of_joints_is_read() -> None:
    model = model_of(URDF)
    np.testing.assert_allclose(model.dof_frictionloss[model.joint("hip_left").dofadr], 0.2)


def test_a_mesh_beside_the_file_needs_no_package(tmp_path: Path) -> None:
    shutil.copy(PACKAGE / "meshes/sole.obj", tmp_path / "sole.obj")
    text = URDF.read_text().replace("package://biped_description/meshes/", "")
    (tmp_path / "biped.urdf").write_text(text)
    assert model_of(tmp_path / "biped.urdf").nmesh == 2


def test_a_broken_file_is_refused_with_the_line(tmp_path: Path) -> None:
    (tmp_path / "biped.urdf").write_text(URDF.read_text().replace("</robot>", "</robo>"))
    with pytest.raises(ValueError, match=r"it is no XML .*line \d+"):
        reader.read(tmp_path / "biped.urdf")
