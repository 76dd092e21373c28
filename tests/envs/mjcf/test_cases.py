"""Small files, each with one thing that is not usual: they walk, or one sentence says why not."""

from pathlib import Path

import pytest

from mjxwalk.envs import MjcfEnv
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import reader
from tests import same_model

CASES = Path(__file__).parent / "files/cases"
# How the refusal begins.
REFUSED = {
    "missing_include": "line 3: the file parts/arms.xml is missing",
    "muscles": "line 8: actuator hip is a muscle",
    "no_gravity": "gravity is 0 0 0 m/s^2",
    "no_plugin": "line 4: the plugin somebodys.own is not at hand",
    "tendon_motor": "line 14: actuator stride drives a tendon",
    "zero_mass": "line 6: body wheel moves and has no mass",
}
# Files that hold one robot, nothing beside it, and all that it needs.
WHOLE = ("ball_joints", "equality", "muscles", "no_floor", "pgs", "rk4", "tendon_motor", "tendons")
NAMES = sorted(path.stem for path in CASES.glob("*.xml"))


def outcome(name: str) -> str:
    """Returns why a file is refused; nothing if it is a body that walks."""
    try:
        body = reader.read(CASES / f"{name}.xml")
    except ValueError as error:
        return str(error)
    try:
        env = MjcfEnv.of(body.text)
    except ValueError as error:
        return body.located(str(error))
    assert [leg.side for leg in env.anatomy.legs] == ["left", "right"]
    return ""


@pytest.mark.parametrize("name", NAMES)
def test_it_walks_or_is_refused_in_one_sentence(name: str) -> None:
    said = outcome(name)
    assert said.startswith(REFUSED[name]) if name in REFUSED else not said
    assert "\n" not in said


@pytest.mark.parametrize("name", WHOLE)
def test_the_text_is_the_same_body_as_the_file(name: str) -> None:
    path = CASES / f"{name}.xml"
    of_file = mujoco.MjModel.from_xml_path(str(path))
    of_text = mujoco.MjModel.from_xml_string(reader.read(path).text)
    same_model.assert_same(of_file, of_text)
    same_model.assert_moves_alike(of_file, of_text)
