"""Tests of what joints do by themselves."""

import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs import motor
from mjxwalk.envs._mujoco import mujoco

WHEEL = """<mujoco><option timestep="0.001" gravity="0 0 0"/><worldbody><body>
  <joint axis="0 1 0" frictionloss="0.5"/><inertial pos="0 0 0" mass="1" diaginertia="1 0.1 1"/>
</body></worldbody></mujoco>"""
INERTIA, FRICTION, TIMESTEP = 0.1, np.array([0.5], np.float32), 0.001


def turned(num: int, *, implicit: bool, rate: float = 3.0, torque: float = 0.0) -> list[float]:
    """Returns how fast a wheel turns after each step, rad/s."""
    ahead = TIMESTEP * implicit
    rates = [rate]
    for _ in range(num):
        drag = motor.rubbed(FRICTION, jnp.float32([rates[-1]]), ahead=ahead)
        inertia = INERTIA + float(drag.added_inertia[0])
        rates.append(rates[-1] + TIMESTEP * (torque + float(drag.torque[0])) / inertia)
    return rates[1:]


@pytest.mark.parametrize("implicit", [True, False])
def test_a_wheel_with_friction_slows_as_in_c_mujoco(implicit: bool) -> None:
    model = mujoco.MjModel.from_xml_string(WHEEL)
    data = mujoco.MjData(model)
    data.qvel[0] = 3.0
    expected: list[float] = []
    for _ in range(800):
        mujoco.mj_step(model, data)
        expected.append(float(data.qvel[0]))
    # 5 rad/s^2 for 0.6 s. MuJoCo's friction is soft too, so both creep to rest in their own way.
    np.testing.assert_allclose(turned(800, implicit=implicit), expected, atol=0.06)
    assert abs(turned(800, implicit=implicit)[-1]) < 1e-3


def test_friction_holds_against_less_torque_and_gives_way_to_more() -> None:
    # At rest a joint creeps at as much of the least full rate as the torque is of the friction.
    assert turned(2000, implicit=True, rate=0.0, torque=0.25)[-1] == pytest.approx(0.05, rel=1e-3)
    # 0.1 N m is left to 0.1 kg m^2; the friction is right to the rate's change in a step.
    fast = turned(2000, implicit=True, rate=1.0, torque=0.6)
    assert fast[-1] - fast[999] == pytest.approx(1.0, rel=3e-3)


def test_a_light_joint_with_much_friction_is_stable_in_implicit_steps() -> None:
    drag = motor.rubbed(np.array([50.0]), jnp.array([2.0]), ahead=0.002)
    after = 2.0 + 0.002 * float(drag.torque[0]) / (1e-4 + float(drag.added_inertia[0]))
    assert 0.0 < after < 0.01  # an explicit step would turn it round at 1,000 rad/s
