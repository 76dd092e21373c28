"""The legs of odd bodies: how many, on which side, and when a body does not stand on them."""

import math
from pathlib import Path

import gymnasium
import numpy as np
import pytest

from mjxwalk.envs import MjcfEnv
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.derived import anatomy, file_tree
from mjxwalk.envs.mjcf import reader

ASSETS = Path(gymnasium.__file__).parent / "envs/mujoco/assets"
TOY = Path(__file__).parents[2] / "toys/toy_biped.xml"


def around(num: int) -> str:
    """Returns the MJCF of a body with legs all around it, the first of them in front."""
    legs = "".join(
        f'''<body name="leg{place}" pos="{0.2 * math.cos(angle)} {0.2 * math.sin(angle)} 0"
          euler="0 0 {math.degrees(angle)}"><joint name="hip{place}" axis="0 1 0"/>
          <geom type="capsule" size="0.02" fromto="0 0 0 0.2 0 -0.3"/></body>'''
        for place in range(num)
        for angle in [2 * math.pi * place / num]
    )
    motors = "".join(f'<motor joint="hip{place}" gear="20"/>' for place in range(num))
    return f"""<mujoco><worldbody><body name="trunk" pos="0 0 0.5"><freejoint/>
      <geom type="sphere" size="0.1" contype="0" conaffinity="0"/>{legs}</body></worldbody>
      <actuator>{motors}</actuator></mujoco>"""


@pytest.mark.parametrize(
    ("num", "sides"),
    [
        (3, "left right middle"),
        (5, "left right left right middle"),
        (6, "left right left right middle middle"),
        (8, "left right left right left right middle middle"),
    ],
)
def test_legs_around_a_body_are_on_their_sides_though_nothing_names_them(
    num: int, sides: str
) -> None:
    found = anatomy.anatomy(around(num))
    assert [leg.side for leg in found.legs] == sides.split()


@pytest.mark.parametrize("num", [3, 5, 6, 8])
def test_mirrored_joints_put_mirrored_legs_where_a_mirror_has_them(num: int) -> None:
    tree, found = file_tree.of_text(around(num)), anatomy.anatomy(around(num))
    model = tree.hinged.mujoco
    ours, seen = mujoco.MjData(model), mujoco.MjData(model)
    values = np.random.default_rng(num).uniform(-0.5, 0.5, num)
    ours.qpos[6:] = values
    for place, each in enumerate(found.coordinates[6:]):
        seen.qpos[each.mirror] = each.sign * values[place]
    for data in (ours, seen):
        mujoco.mj_kinematics(model, data)
    places, mirrored = (
        sorted(tuple(np.round(x * [1, sign, 1], 6)) for x in data.geom_xpos)
        for data, sign in ((ours, 1), (seen, -1))
    )
    assert np.allclose(places, mirrored, atol=1e-5)


def test_a_biped_that_lies_is_refused() -> None:
    with pytest.raises(ValueError, match="body torso lies in the pose that trials start in"):
        MjcfEnv.of(reader.read(ASSETS / "humanoidstandup.xml").text)


def test_a_foot_that_is_kept_from_the_ground_is_none(tmp_path: Path) -> None:
    text = TOY.read_text()
    touches = text.replace('size="0.1 0.06 0.01"', 'size="0.1 0.06 0.01" contype="1"')
    kept = '<contact><exclude body1="shank_left" body2="world"/></contact></mujoco>'
    path = tmp_path / "robot.xml"
    path.write_text(touches.replace("</mujoco>", kept))
    read = reader.read(path).text
    assert '<exclude body1="world" body2="shank_left"/>' in read
    with pytest.raises(ValueError, match=r"only one leg reaches the ground .* shank_right"):
        MjcfEnv.of(read)
    assert len(MjcfEnv.of(touches).anatomy.legs) == 2


def test_a_motor_without_gear_is_refused() -> None:
    text = TOY.read_text().replace(
        '<motor joint="hip_left"/>', '<motor joint="hip_left" gear="0"/>'
    )
    with pytest.raises(ValueError, match="moves nothing, as its gear is 0"):
        MjcfEnv.of(text)


def test_a_motor_that_pulls_to_one_side_alone_holds_targets() -> None:
    text = TOY.read_text().replace('ctrlrange="-40 40"', 'ctrlrange="0 40"')
    found = MjcfEnv.of(text).anatomy.motors
    assert all((each.lowest, each.highest) == (0.0, 40.0) and each.stiffness for each in found)
    assert all(each.strength == 40.0 for each in anatomy.anatomy(text, "torque").motors)
