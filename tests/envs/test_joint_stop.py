"""Tests of the soft joint limits."""

import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs import JointStop, StopTorque

LAW = JointStop(stiffness=100.0, damping=2.0)
LOWER, UPPER = np.array([-1.0], np.float32), np.array([0.5], np.float32)


def stop(angle: float, rate: float, implicit: bool = False) -> StopTorque:
    angles, rates = jnp.array([angle]), jnp.array([rate])
    return LAW.torque(angles, rates, LOWER, UPPER, timestep=0.01, implicit=implicit)


def test_inside_the_range_nothing_acts() -> None:
    assert stop(0.4, 9.0).torque == 0.0 and stop(-0.9, -9.0, implicit=True).added_inertia == 0.0


def test_beyond_the_range_it_pushes_back() -> None:
    np.testing.assert_allclose(stop(0.7, 1.0).torque, [-(100 * 0.2 + 2 * 1.0)], rtol=1e-5)
    np.testing.assert_allclose(stop(-1.1, -1.0).torque, [100 * 0.1 + 2 * 1.0], rtol=1e-5)


def test_it_never_holds_a_joint_that_returns() -> None:
    assert stop(0.51, -5.0).torque == 0.0
    assert stop(-1.01, 5.0).torque == 0.0


def test_implicit_part_is_backward_euler() -> None:
    inertia, angle, rate, dt = 0.1, 0.7, 1.0, 0.01
    push = stop(angle, rate, implicit=True)
    after = rate + dt * float(push.torque[0]) / (inertia + float(push.added_inertia[0]))
    # I (w' - w) / dt = -k (angle + dt w' - upper) - d w', solved for w' by hand.
    wanted = (inertia * rate / dt - 100 * 0.2) / (inertia / dt + 100 * dt + 2)
    np.testing.assert_allclose(after, wanted, rtol=1e-5)


def test_negative_stiffness_is_refused() -> None:
    with pytest.raises(ValueError, match="stiffness must be a number above 0, got -1.0"):
        JointStop(stiffness=-1.0)
