"""Tests of which tree of a file is the robot."""

from pathlib import Path

import pytest

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import reader

ROBOT = """<body name="{name}"><freejoint/><geom size="0.1"/>
  <body name="{name}_leg"><joint name="{name}_hip" axis="0 1 0"/><geom size="0.1"/>{inside}</body>
</body>"""


def read(tmp_path: Path, world: str, after: str = "") -> reader.BodyFile:
    path = tmp_path / "robot.xml"
    path.write_text(f"<mujoco><worldbody>{world}</worldbody>{after}</mujoco>")
    return reader.read(path)


def test_things_beside_the_robot_are_left_out(tmp_path: Path) -> None:
    world = (
        '<body name="ball"><freejoint/><geom size="0.1"/></body>'
        '<body name="wall"><geom size="0.1"/></body><body name="post"><geom size="0.1"/></body>'
        '<body name="hand" mocap="true"><geom size="0.1"/></body>'
    )
    found = read(tmp_path, world + ROBOT.format(name="robot", inside=""))
    assert found.notes[:3] == (
        "Body hand is moved from outside (mocap); it is left out.",
        "Body ball moves beside the robot; it is left out.",
        "Bodies wall and post stand beside the robot; they are left out.",
    )
    assert mujoco.MjModel.from_xml_string(found.text).nbody == 3


def test_two_robots_are_refused_unless_one_alone_has_motors(tmp_path: Path) -> None:
    world = "".join(ROBOT.format(name=name, inside="") for name in ("one", "two"))
    with pytest.raises(ValueError, match="bodies one and two have as many joints and actuators"):
        read(tmp_path, world)
    found = read(tmp_path, world, '<actuator><motor joint="two_hip"/></actuator>')
    assert 'name="two"' in found.text and 'name="one"' not in found.text


def test_soft_parts_are_refused(tmp_path: Path) -> None:
    skin = (
        '<flexcomp name="skin" type="grid" count="3 3 1" spacing=".1 .1 .1" mass="1" dim="2" '
        'radius=".01"/>'
    )
    with pytest.raises(ValueError, match="the robot has a soft part, flex skin"):
        read(tmp_path, ROBOT.format(name="robot", inside=skin))


def test_plugins_are_refused(tmp_path: Path) -> None:
    after = (
        '<extension><plugin plugin="mujoco.pid"/></extension><actuator>'
        '<plugin name="pid" joint="robot_hip" plugin="mujoco.pid"/></actuator>'
    )
    with pytest.raises(ValueError, match="actuator pid is run by a plugin"):
        read(tmp_path, ROBOT.format(name="robot", inside=""), after)


def test_too_many_bodies_are_refused(tmp_path: Path) -> None:
    spurs = "".join(f'<body name="spur_{num}"><geom size="0.1"/></body>' for num in range(100))
    with pytest.raises(ValueError, match="^<body> is one too many; a body may have"):
        read(tmp_path, ROBOT.format(name="robot", inside=spurs))


def test_files_that_include_each_other_end(tmp_path: Path) -> None:
    (tmp_path / "part.xml").write_text('<mujoco><include file="part.xml"/></mujoco>')
    with pytest.raises(ValueError, match=r"the file part\.xml is included twice"):
        read(tmp_path, "", '<include file="part.xml"/>')
