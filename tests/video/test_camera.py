"""Tests of where walkers are filmed from."""

import functools

import pytest

from mjxwalk.envs import Flame, LeggedEnv, Planar7, Reil
from mjxwalk.envs.mjcf_env import MjcfEnv
from mjxwalk.pictures import camera

ARM = """<body name="{name}_thigh"><joint name="{name}_hip" axis="0 1 0" range="-60 60"/>
  <geom type="capsule" size="0.05" fromto="0 0 0 {x} {y} 0"/>
  <body name="{name}_shank" pos="{x} {y} 0"><joint name="{name}_knee" axis="0 1 0" range="-40 40"/>
    <geom type="capsule" size="0.05" fromto="0 0 0 0 0 -0.3"/></body></body>"""
LEGS = {
    "front_left": (0.8, 0.8),
    "front_right": (0.8, -0.8),
    "back_left": (-0.8, 0.8),
    "back_right": (-0.8, -0.8),
}


@functools.cache
def wide() -> MjcfEnv:
    """Returns a body on four legs whose feet are far from its middle."""
    legs = "".join(ARM.format(name=name, x=x, y=y) for name, (x, y) in LEGS.items())
    motors = "".join(
        f'<motor joint="{name}_{joint}" gear="50" ctrlrange="-1 1"/>'
        for name in LEGS
        for joint in ("hip", "knee")
    )
    return MjcfEnv.of(
        '<mujoco model="wide"><worldbody><body name="torso" pos="0 0 0.35"><freejoint/>'
        f'<geom type="sphere" size="0.2"/>{legs}</body></worldbody>'
        f"<actuator>{motors}</actuator></mujoco>"
    )


@pytest.mark.parametrize("env", [Planar7(), Flame(), Reil()], ids=["planar", "spatial", "hips"])
def test_the_camera_is_as_far_from_a_biped_as_its_legs_are_long(env: LeggedEnv) -> None:
    assert camera.distance(env) == camera.DISTANCE * env.leg_length


def test_the_camera_sees_all_of_a_wide_body() -> None:
    apart = 0.8 * 2**0.5  # m, of the feet from the middle
    found = camera.distance(wide())
    assert found == pytest.approx(camera.DISTANCE * camera.SPREAD * apart, rel=1e-3)
    # MuJoCo's camera sees 45 degrees from top to bottom, and more across.
    assert found * 0.41 > 1.2 * apart
