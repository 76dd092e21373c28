"""Tests of motors that are force-limited velocity constraints."""

import jax
import jax.numpy as jnp
import numpy as np
from c_mujoco_reil import best_in_box

from mjxwalk.envs.velocity_motor import VelocityMotor, limited_pair


def test_torques_are_the_best_in_the_box_that_trying_every_face_finds() -> None:
    random = np.random.default_rng(0)
    roots = random.normal(size=(300, 2, 2))
    matrices = roots @ roots.swapaxes(1, 2) + np.eye(2) * 10 ** random.uniform(-1, 0, (300, 1, 1))
    wanted = random.normal(size=(300, 2)) * 10 ** random.uniform(-1, 1, (300, 1))
    found = jax.vmap(limited_pair, (0, 0, None))(jnp.asarray(matrices), jnp.asarray(wanted), 1.0)
    best = [best_in_box(a, b, 1.0) for a, b in zip(matrices, wanted, strict=True)]
    np.testing.assert_allclose(found, best, atol=1e-4)  # float32, condition numbers up to 100
    at_limit = (np.abs(best) == 1.0).sum(axis=1)
    assert set(at_limit.tolist()) == {0, 1, 2}


def test_a_request_is_a_share_of_what_is_missing_and_has_a_limit() -> None:
    motor = VelocityMotor(approach=10.0, max_speed=2.0, max_torque=1.0)
    asked = motor.request(jnp.array([0.1, -1.0]), jnp.zeros(2))
    np.testing.assert_allclose(asked, [1.0, -2.0])


def test_a_soft_motor_falls_short_of_its_request_by_its_torque() -> None:
    motor = VelocityMotor(approach=1.0, max_speed=9.0, max_torque=100.0, softness=0.5)
    # Alone, 3 rad/s in answer to 1 N m: a torque t gives 3 t = 7 - 0.5 t.
    torques = motor.torques(3.0 * jnp.eye(2), jnp.array([7.0, 0.0]))
    np.testing.assert_allclose(torques, [2.0, 0.0])
