"""A file that MuJoCo cannot take is refused in one sentence with element and line."""

from pathlib import Path

import pytest

from mjxwalk.envs.mjcf import reader

MJCF = """<mujoco>
  <worldbody>
    <body name="trunk" pos="0 0 1">
      <freejoint/>
      <geom size="0.1"/>
      <body name="leg">
        <joint name="hip" axis="0 1 0"/>
        <geom size="0.1"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="hip" joint="hip"/>
  </actuator>
</mujoco>
"""
LEG = '<geom size="0.1"/>\n      </body>'
# Of each fault what it changes, and how the refusal begins.
FAULTS = {
    "zero mass": (LEG, "</body>", "line 6: body leg moves and has no mass; give it"),
    "no inertia": (
        LEG,
        '<inertial pos="0 0 0" mass="1" diaginertia="1 1 3"/></body>',
        "line 6: the inertia of body leg is that of nothing",
    ),
    "a plugin": (
        "<worldbody>",
        '<extension><plugin plugin="my.own"/></extension><worldbody>',
        "line 2: the plugin my.own is not at hand",
    ),
    "no such joint": (
        'joint="hip"/>',
        'joint="knee"/>',
        "line 13: actuator hip drives knee, which the file does not have",
    ),
    "no such class": ("<freejoint/>", '<site class="a"/>', "line 4: the class a has no <default>"),
    "no such attribute": ('"0 1 0"', '"0 1 0" ranges="1 2"', "line 7: <joint> has no attribute"),
    "no such element": ("<freejoint/>", "<wheel/>", "line 4: <wheel> has no place there"),
    "a word for a number": (
        '"0 1 0"',
        '"y"',
        "line 7: MuJoCo cannot take it: bad format in attribute 'axis' in <joint>; correct it",
    ),
    "a name twice": (
        "<freejoint/>",
        '<joint name="hip"/>',
        "line 7: MuJoCo cannot take it: repeated name 'hip' in joint in <joint>; correct it",
    ),
    "no such file": (
        "<freejoint/>",
        '<include file="nowhere.xml"/>',
        "line 4: the file nowhere.xml is missing",
    ),
    "no end": ("    </body>\n  </worldbody>", "</worldbody>", "line 3: it is no XML"),
    "a muscle without a range": (
        '<motor name="hip" joint="hip"/>',
        '<muscle joint="hip"/>',
        "line 13: MuJoCo finds no range of lengths for the muscle number 0; give it a lengthrange",
    ),
    "not a number": (
        'axis="0 1 0"',
        'axis="0 nan 0"',
        "line 7: axis of <joint> holds nan, which is no number",
    ),
    "a range without an end": (
        'joint="hip"/>',
        'joint="hip" ctrlrange="-1 inf"/>',
        "line 13: ctrlrange of <motor> holds inf, which is no number",
    ),
    "a damper that drives": (
        '"0 1 0"',
        '"0 1 0" damping="-5"',
        "line 7: joint hip has a damping of -5",
    ),
    "no such model to attach": (
        "<worldbody>",
        '<asset><model name="leg" file="nowhere.xml"/></asset><worldbody>',
        "line 2: the file ",
    ),
    "another format": ("mujoco>", "sdf>", "its first element is <sdf>; write <mujoco>, or a URDF"),
}


def refusal(path: Path) -> str:
    with pytest.raises(ValueError) as refused:
        reader.read(path)
    assert "\n" not in str(refused.value) and "Element" not in str(refused.value)
    return str(refused.value)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_said_in_one_sentence(tmp_path: Path, fault: str) -> None:
    old, new, begin = FAULTS[fault]
    assert old in MJCF
    path = tmp_path / "robot.xml"
    path.write_text(MJCF.replace(old, new))
    assert refusal(path).startswith(begin)


def test_the_line_is_that_of_the_included_file(tmp_path: Path) -> None:
    inner = MJCF[MJCF.index("  <actuator>") : MJCF.index("</mujoco>")].replace('t="hip', 't="knee')
    (tmp_path / "motors.xml").write_text(f"<mujoco>\n{inner}</mujoco>")
    path = tmp_path / "robot.xml"
    path.write_text(
        MJCF[: MJCF.index("  <actuator>")] + '  <include file="motors.xml"/>\n</mujoco>'
    )
    assert refusal(path).startswith("line 3 of motors.xml: actuator hip drives knee")


@pytest.mark.parametrize("inner", [False, True])
def test_names_in_another_encoding_are_refused(tmp_path: Path, inner: bool) -> None:
    text = MJCF.replace('"hip"', '"h\u00fcfte"')
    if inner:
        (tmp_path / "inner.xml").write_text(text, encoding="latin-1")
        text = '<mujoco><include file="inner.xml"/></mujoco>'
    path = tmp_path / "robot.xml"
    path.write_text(text, encoding="latin-1")
    assert "save it" in refusal(path) and "UTF-8" in refusal(path)


@pytest.mark.parametrize("text", ["", "a robot", "<mujoco/>"])
def test_what_is_no_robot_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(text)
    assert refusal(path).startswith(("it is empty", "line 1: it is no XML", "it has no bodies"))


def test_bytes_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    path.write_bytes(bytes(range(256)))
    assert refusal(path)
