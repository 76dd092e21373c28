"""Steps under MuJoCo's own contacts, against C MuJoCo's, from the same states."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import c_contacts
import jax
import numpy as np
import pytest
from c_contacts import CONVERGED, model_of, stepping, text_of

from mjxwalk.engines import lanes
from mjxwalk.envs.mujoco_law.settings import MujocoContact

GYMNASIUM = Path(pytest.importorskip("gymnasium").__file__).parent / "envs/mujoco/assets"
EULER = MujocoContact(iterations=100, ls_iterations=20, integrator="euler")
ELLIPTIC = MujocoContact(
    iterations=100, ls_iterations=20, cone="elliptic", integrator="implicitfast"
)
# A hopper on a leg that two joints tie to a second one, with a tendon, friction in a joint, and
# geoms of every shape that may touch the floor.
TIED = """
<mujoco>
  <option timestep="0.003"/>
  <default>
    <joint damping="0.5" armature="0.02"/><geom density="500" contype="0" conaffinity="2"/>
  </default>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1" contype="2" conaffinity="0"/>
    <body name="trunk" pos="0 0 0.9">
      <freejoint/>
      <geom type="box" size="0.1 0.15 0.1"/>
      {legs}
    </body>
  </worldbody>
  <tendon>
    <fixed name="across" range="-0.2 0.3" damping="1" stiffness="20" frictionloss="0.5">
      <joint joint="hip_left" coef="1"/><joint joint="hip_right" coef="-1"/>
    </fixed>
  </tendon>
  <equality>
    <joint joint1="ankle_left" joint2="knee_left" polycoef="0 -0.5 0.1 0 0"/>
    <connect body1="heel_right" body2="foot_right" anchor="0 0 0"/>
  </equality>
  <actuator>
    <motor joint="hip_left" ctrlrange="-50 50"/><motor joint="knee_left" ctrlrange="-50 50"/>
    <motor joint="hip_right" ctrlrange="-50 50"/><motor joint="knee_right" ctrlrange="-50 50"/>
  </actuator>
</mujoco>
"""
LEG = """
      <body name="thigh_{s}" pos="0 {y} -0.1">
        <joint name="hip_{s}" axis="0 1 0" range="-60 60"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.35" size="0.04" {solid}/>
        <body name="shin_{s}" pos="0 0 -0.35">
          <joint name="knee_{s}" axis="0 1 0" range="-10 120" frictionloss="1"/>
          <geom type="cylinder" fromto="0 0 0 0 0 -0.3" size="0.03"/>
          <body name="foot_{s}" pos="0 0 -0.35">
            <joint name="ankle_{s}" axis="0 1 0" range="-40 40"/>
            <geom type="{shape}" size="0.12 0.05 0.03" condim="{dim}"/>
            <body name="heel_{s}" pos="-0.1 0 0">
              <joint name="pad_{s}" type="slide" axis="0 0 1" range="-0.02 0.02"/>
              <geom type="sphere" size="0.04" condim="6" mass="0.2" {solid}/>
            </body>
          </body>
        </body>
      </body>
"""


@pytest.fixture(scope="module")
def tied(tmp_path_factory: Any) -> str:
    path = tmp_path_factory.mktemp("body") / "tied.xml"
    solid = 'contype="1" conaffinity="3"'
    legs = LEG.format(s="left", y=0.1, shape="box", dim=4, solid=solid)
    legs += LEG.format(s="right", y=-0.1, shape="ellipsoid", dim=3, solid=solid)
    path.write_text(TIED.format(legs=legs))
    return str(path)


def compare(name: str, law: MujocoContact, share: float = 1.0) -> None:
    """Raises unless float32 steps in lanes agree with C MuJoCo's in float64.

    Velocities change by some 10 m/s^2 times mass over inertia of single joints, a thousand rad/s^2,
    times a time step of some ms; six digits of such a change are 1e-5 rad/s, and a solver that
    starts elsewhere stops 10 of those away.

    Args:
      share: of the states in which they do; the others touch as MJX has it.
    """
    text = text_of(name)
    model = model_of(text, law)
    given = c_contacts.steps(text, model)
    assert (given.contacts > 0).mean() > 0.5
    f32 = jax.tree.map(lambda leaf: leaf.astype(np.float32), (given.before, given.action))
    after = lanes.vmap(stepping(model))(*f32)
    off = np.abs(after.qvel - given.qvel).max(1)
    assert np.mean(off < 5e-4) >= share
    close = off < 5e-4
    np.testing.assert_allclose(after.qpos[close], given.qpos[close], atol=2e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "law", "share"),
    [
        ("h1", CONVERGED, 1.0),
        ("walker2d", CONVERGED, 1.0),
        ("walker2d", ELLIPTIC, 1.0),
        # Boxes against each other, and steep capsules against planes, touch otherwise in MJX.
        ("g1", CONVERGED, 0.95),
        (str(GYMNASIUM / "humanoid.xml"), EULER, 0.99),
        (str(GYMNASIUM / "walker2d_v5.xml"), CONVERGED, 1.0),  # by Runge and Kutta
    ],
)
def test_a_float32_step_agrees_with_c_mujoco(name: str, law: MujocoContact, share: float) -> None:
    compare(name, law, share)


@pytest.mark.slow
@pytest.mark.parametrize("law", [CONVERGED, ELLIPTIC])
def test_constraints_tendons_and_all_shapes_agree_with_c_mujoco(
    tied: str, law: MujocoContact
) -> None:
    compare(tied, law)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["h1", "walker2d"])
def test_a_float64_step_agrees_with_c_mujoco_to_its_last_digits(name: str) -> None:
    """What float32 hides shows in float64: every part of the step is MuJoCo's."""
    environment = {
        **os.environ,
        "JAX_ENABLE_X64": "1",
        "PYTHONPATH": str(Path(__file__).parents[1]),
    }
    told = subprocess.run(
        [sys.executable, c_contacts.__file__, name],
        env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert float(told.stdout.split()[-1]) < 1e-8
