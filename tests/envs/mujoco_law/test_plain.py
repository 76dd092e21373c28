"""Tests of bodies with the joints and motors of their file."""

import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs.mujoco_law import plain
from mjxwalk.envs.mujoco_law.settings import MujocoContact

TEXT = """
<mujoco>
  <option timestep="0.004"/>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <body name="trunk" pos="0 0 0.4">
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint axis="0 1 0"/>
      <geom name="low" type="sphere" size="0.1" pos="0.3 0 0"/>
      <geom name="high" type="capsule" size="0.1 0.1" pos="-0.3 0 0.3"/>
      <geom name="free" type="sphere" size="0.1" pos="0 0 1" contype="0" conaffinity="0"/>
      <body name="leg">
        <joint name="hip" axis="0 1 0"/>
        <geom name="shank" type="capsule" fromto="0 0 0 0 0 -0.3" size="0.04"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="hip" gear="50" ctrlrange="-0.4 0.2"/></actuator>
</mujoco>
"""


def test_all_geoms_of_a_body_touch_the_ground() -> None:
    """MuJoCo passes over bodies of several geoms by boxes about them all."""
    model = plain.of_text(TEXT, MujocoContact()).law
    touching = {model.mujoco.geom(int(geom)).name for each in model.ground for geom in each.geom}
    assert touching == {"low", "high", "shank"}


def test_motors_turn_controls_into_torques() -> None:
    model = plain.of_text(TEXT, MujocoContact())
    assert model.names == ("hip",)
    for value, ctrl, torque in ((-1.0, -0.4, -20.0), (1.0, 0.2, 10.0), (3.0, 0.8, 10.0)):
        asked = plain.controls(model, jnp.array([value]))
        np.testing.assert_allclose(asked, ctrl, rtol=1e-6)
        np.testing.assert_allclose(plain.action(model, asked).torque, torque, rtol=1e-6)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('size="0 0 1"/>', 'size="0 0 1" pos="0 0 0.1"/>', "floor is a floor that is not level"),
        ('<geom name="floor" type="plane" size="0 0 1"/>', "", "has no floor"),
        ('<motor joint="hip" gear="50" ctrlrange="-0.4 0.2"/>', "", "has no actuators"),
        ('<motor joint="hip" gear="50"', '<position joint="hip" kp="5"', "is no motor of a joint"),
        ('<joint type="slide" axis="1 0 0"/>', "", "moves by one slide and one hinge"),
    ],
)
def test_what_cannot_be_moved_is_refused(old: str, new: str, sentence: str) -> None:
    assert old in TEXT
    with pytest.raises(ValueError, match=sentence):
        plain.of_text(TEXT.replace(old, new), MujocoContact())
