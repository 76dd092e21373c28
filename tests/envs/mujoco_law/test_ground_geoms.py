"""Where geoms may touch the ground, of files with and without a floor of their own."""

import numpy as np
import pytest

from mjxwalk.envs.mujoco_law import model
from mjxwalk.envs.mujoco_law.settings import MujocoContact

FLOOR = '<geom type="plane" size="0 0 1"/>'
SOLE = "-.1 -.05 -.04  .1 -.05 -.04  -.1 .05 -.04  .1 .05 -.04  0 0 .04"
LEG = """
<body name="{side} thigh" pos="0 {y} 0"><joint name="{side} hip" axis="0 1 0" range="-60 60"/>
  <geom type="capsule" fromto="0 0 0 0 0 -.4" size=".05" mass="3" contype="0" conaffinity="0"/>
  <body name="{side} shin" pos="0 0 -.4"><joint name="{side} knee" axis="0 1 0" range="0 90"/>
    <geom type="capsule" fromto="0 0 0 0 0 -.4" size=".04" mass="2" contype="0" conaffinity="0"/>
    <body name="{side} foot" pos="0 0 -.4"><joint name="{side} ankle" axis="0 1 0" range="-40 40"/>
      <geom name="{side} sole" type="mesh" mesh="sole" mass="1" conaffinity="0"/>
    </body>
  </body>
</body>"""
BODY = """
<mujoco>
  <asset><mesh name="sole" vertex="{sole}"/></asset>
  <worldbody>{floor}
    <body name="torso" pos="0 0 .85"><freejoint/>
      <geom type="box" size=".1 .15 .2" pos="0 0 .2" mass="20" contype="0" conaffinity="0"/>
      {legs}
    </body>
  </worldbody>
  <actuator>{motors}</actuator>
</mujoco>"""


def text(floor: str) -> str:
    sides = {"left": 0.1, "right": -0.1}
    legs = "".join(LEG.format(side=side, y=y) for side, y in sides.items())
    motors = "".join(
        f'<motor joint="{side} {joint}" gear="60" ctrlrange="-1 1"/>'
        for side in sides
        for joint in ("hip", "knee", "ankle")
    )
    return BODY.format(floor=floor, sole=SOLE, legs=legs, motors=motors)


@pytest.mark.parametrize("floor", [FLOOR, ""], ids=["own floor", "no floor"])
def test_corners_of_a_mesh_are_its_own_with_and_without_a_floor(floor: str) -> None:
    law = MujocoContact()
    made = model.of_text(text(floor), law, 0.002)
    corners = [each for contacts in made.ground for each in contacts.corners]
    assert len(corners) == 2
    found = made.mujoco
    for each, geom in zip(corners, made.ground[0].shapes[0][1], strict=True):
        start = found.mesh_vertadr[found.geom_dataid[geom]]
        vertices = found.mesh_vert[start : start + 5]
        apart = np.linalg.norm(vertices[:, None] - each[None], axis=-1)
        assert each.shape == (4, 3)
        np.testing.assert_allclose(apart.min(axis=0), 0.0, atol=1e-6)
