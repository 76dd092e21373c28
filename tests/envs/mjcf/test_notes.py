"""Tests of what users are told about their files."""

from pathlib import Path

import gymnasium
import pytest

from mjxwalk.envs import MjcfEnv
from mjxwalk.envs.mjcf import reader
from mjxwalk.envs.mjcf.notes import listed

ASSETS = Path(gymnasium.__file__).parent / "envs/mujoco/assets"
TOY = Path(__file__).parents[2] / "toys/toy_biped.xml"
KNEE = '<joint name="knee_left" axis="0 1 0"'
# What changes in the toy's file, and the note of it for contact law points.
REPLACED = {
    "RK4": (
        "<default>",
        '<option integrator="RK4"/><default>',
        "Line 4: the integrator RK4 is replaced by semi-implicit Euler with implicit contacts.",
    ),
    "a solver": (
        "<default>",
        '<option solver="CG"/><default>',
        "Line 4: the solver CG is not needed; contact law points has springs and dampers.",
    ),
    "air": (
        "<default>",
        '<option density="1.2"/><default>',
        "Line 4: the medium's density is left out.",
    ),
    "a range the wrong way round": (
        '<joint name="knee_left" axis="0 1 0" range="0 90"/>',
        '<joint name="knee_left" axis="0 1 0" range="90 0"/>',
        "Line 4: range of joint knee_left ends before it begins, and limits nothing.",
    ),
    "a constant force": (
        '<motor joint="hip_left"/>',
        '<general name="hip" joint="hip_left" biastype="affine" biasprm="7 -80 -4"/>',
        "Line 4: actuator hip does not push; contact law points has no constant force (biasprm).",
    ),
}


@pytest.mark.parametrize("kind", REPLACED)
def test_what_contact_law_points_replaces_is_said_with_its_line(tmp_path: Path, kind: str) -> None:
    old, new, note = REPLACED[kind]
    text = TOY.read_text()
    line = text[: text.index(old)].count("\n") + 1
    path = tmp_path / "toy.xml"
    path.write_text(text.replace(old, new, 1))
    found = reader.read(path)
    assert found.points == (note.replace("Line 4", f"Line {line}"),)
    assert MjcfEnv.of(found.text)


def test_tendons_are_said_to_be_left_out() -> None:
    points = reader.read(ASSETS / "humanoid.xml").points
    assert any(note.startswith("Tendons left_hipknee and right_hipknee are") for note in points)


@pytest.mark.parametrize(
    ("names", "sentence"),
    [
        (["a"], "body a is"),
        (["a", "b"], "bodies a and b are"),
        (["a", "b", "c", "d"], "bodies a, b, c and d are"),
        (["a", "b", "c", "d", "e"], "bodies a, b, c and 2 more are"),
        (["", ""], "2 bodies are"),
        ([""], "a body without a name is"),
    ],
)
def test_things_are_listed(names: list[str], sentence: str) -> None:
    assert listed("body", names, "is", "are") == sentence


def test_a_refusal_is_located_by_the_element_that_it_names(tmp_path: Path) -> None:
    path = tmp_path / "toy.xml"
    text = TOY.read_text().replace('<motor joint="hip_left"/>', '<motor joint="root_x" name="x"/>')
    path.write_text(text)
    found = reader.read(path)
    with pytest.raises(ValueError) as refused:
        MjcfEnv.of(found.text)
    line = text[: text.index('name="x"')].count("\n") + 1
    assert found.located(str(refused.value)).startswith(f"line {line}: actuator x drives the root")
