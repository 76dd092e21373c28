"""Tests of the root's attitude and of kinematics in the root's axes."""

import copy
from typing import Any

import jax
import jax.numpy as jnp
import mujoco as _mujoco
import numpy as np

from mjxwalk.envs import Flame, floating

mujoco: Any = _mujoco
EULER = jnp.array([0.7, -0.4, 0.3])
RATES = jnp.array([0.5, -1.2, 2.0])


def test_rotation_is_that_of_three_hinges_in_c_mujoco() -> None:
    model = Flame().model.mujoco
    data = mujoco.MjData(model)
    data.qpos[3:6], data.qvel[3:6] = EULER, RATES
    mujoco.mj_forward(model, data)
    axes = data.body("torso").xmat.reshape(3, 3)
    np.testing.assert_allclose(floating.rotation(EULER), axes, atol=1e-6)
    motion, torso = np.zeros(6), model.body("torso").id
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, torso, motion, 1)
    np.testing.assert_allclose(floating.spin(EULER, RATES), motion[:3], atol=1e-6)


def test_euler_acceleration_is_the_inverse_of_the_spins_derivative() -> None:
    wanted = jnp.array([1.5, -0.3, 0.8])
    _, turning = jax.jvp(floating.spin, (EULER, RATES), (RATES, wanted))
    got = floating.euler_acceleration(EULER, RATES, turning)
    np.testing.assert_allclose(got, wanted, rtol=1e-5)


def test_kinematics_and_bias_forces_are_those_of_c_mujoco() -> None:
    key = np.random.default_rng(0)
    floated = Flame().floating
    model = copy.copy(floated.mujoco)
    angles, qvel = key.uniform(-0.5, 0.5, 10), key.normal(size=16)
    down = np.array([2.0, -1.0, -9.0])
    model.opt.gravity[:] = down
    data = mujoco.MjData(model)
    data.qpos[7:], data.qvel[:] = angles, qvel
    mujoco.mj_forward(model, data)
    joints, rates, gravity = (jnp.asarray(x, jnp.float32) for x in (angles, qvel, down))
    ours = floating.forward(floated, joints, rates, gravity)
    np.testing.assert_allclose(ours.xpos[1:], data.xpos[1:], atol=1e-6)
    np.testing.assert_allclose(ours.xmat[1:], data.xmat[1:].reshape(-1, 3, 3), atol=1e-6)
    # Sums of some 100 N over ten bodies, in float32.
    np.testing.assert_allclose(ours.qfrc_bias, data.qfrc_bias, atol=2e-4)
