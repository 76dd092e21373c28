"""Tests of reading a user's file: the text is the file's body, and all else is said."""

import re
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from mjxwalk.envs import body_xml
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import reader
from tests import same_model

HERE = Path(__file__).parent / "files"
BIPED = HERE / "biped.xml"
ASSETS = Path(gymnasium.__file__).parent / "envs/mujoco/assets"
# Files that hold one robot and nothing beside it.
KEYS = [f"key_{name}" for name in ("time", "qpos", "qvel", "act", "mpos", "mquat", "ctrl")]
WHOLE = (
    "ant half_cheetah hopper humanoid humanoidstandup point swimmer walker2d walker2d_v5"
).split()


def compiled(text: str) -> Any:
    """Returns the model of a text, which no other file is at hand for."""
    return mujoco.MjModel.from_xml_string(text)


@pytest.mark.parametrize("name", WHOLE)
def test_the_text_is_the_same_body_as_the_file(name: str) -> None:
    path = ASSETS / f"{name}.xml"
    of_file, of_text = (
        mujoco.MjModel.from_xml_path(str(path)),
        compiled(reader.read(path).text),
    )
    # Gymnasium's `init_qpos` becomes a keyframe.
    same_model.assert_same(of_file, of_text, ignoring=KEYS)
    same_model.assert_moves_alike(of_file, of_text)


def without_mesh() -> Any:
    """Returns the biped as MuJoCo compiles it once nothing is drawn by the missing mesh."""
    spec = mujoco.MjSpec.from_file(str(BIPED))
    spec.delete(next(geom for geom in spec.geoms if geom.meshname))
    spec.delete(spec.meshes[0])
    return spec.compile()


def test_includes_classes_frames_and_turns_are_resolved() -> None:
    text = reader.read(BIPED).text
    assert not re.search("include|class|frame |file|euler=|deg", text)
    same_model.assert_same(without_mesh(), compiled(text))
    same_model.assert_moves_alike(without_mesh(), compiled(text))


def test_a_read_text_is_read_as_itself(tmp_path: Path) -> None:
    text = reader.read(BIPED).text
    assert body_xml.checked(text)
    again = tmp_path / "again.xml"
    again.write_text(text)
    same_model.assert_same(compiled(text), compiled(reader.read(again).text))


def test_the_text_has_all_digits_of_the_file() -> None:
    ipos = compiled(reader.read(BIPED).text).body("thigh_left").inertia
    np.testing.assert_allclose(ipos, without_mesh().body("thigh_left").inertia, rtol=1e-15)


def test_a_mesh_that_only_draws_may_be_missing() -> None:
    notes = reader.read(BIPED).notes
    missing = HERE / "nowhere/pelvis.stl"
    assert f"The mesh {missing} is missing; body pelvis is drawn without it." in notes


def changed(tmp_path: Path, old: str, new: str) -> Path:
    """Returns a copy of the biped in which a part is another."""
    for path in HERE.rglob("*.xml"):
        copy = tmp_path / path.relative_to(HERE)
        copy.parent.mkdir(exist_ok=True)
        copy.write_text(path.read_text())
    text = BIPED.read_text()
    assert old in text
    (tmp_path / "biped.xml").write_text(text.replace(old, new))
    return tmp_path / "biped.xml"


def test_a_mesh_that_collides_may_not_be_missing(tmp_path: Path) -> None:
    path = changed(tmp_path, 'mesh="pelvis"', 'mesh="pelvis" contype="1"')
    with pytest.raises(ValueError, match=r"pelvis\.stl is missing, and body pelvis collides by it"):
        reader.read(path)


def test_a_mesh_that_makes_a_body_heavy_may_not_be_missing(tmp_path: Path) -> None:
    inertial = re.search("<inertial .*/>", BIPED.read_text())
    assert inertial
    path = changed(tmp_path, inertial[0], "")
    with pytest.raises(ValueError, match="is missing, and the mass of body pelvis comes from it"):
        reader.read(path)
