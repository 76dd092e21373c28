"""Tests of the second laws of ground and motors."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from c_mujoco_reil import best_in_box

from mjxwalk.envs import RandomWalk, SerpentineWalk, Terrain, TrialVariation, VelocityMotor
from mjxwalk.verify import laws


@pytest.mark.parametrize(
    "shape",
    [RandomWalk(), SerpentineWalk(length=8.0, width=2.0), TrialVariation(slope=0.1)],
    ids=["line", "grid", "slope"],
)
def test_ground_is_as_high_as_the_walkers_is(shape: Any) -> None:
    key = jax.random.key(0)
    heights = (
        shape.sample_trials(key, 3).heights if hasattr(shape, "slope") else shape.sample(key, 3)
    )
    heights = np.asarray(heights)
    places = np.random.default_rng(0).uniform(-4.0, 9.0, (3, 40, 2))
    found = laws.height(shape, heights.astype(np.float64), places[..., 0], places[..., 1])
    tangents = 1 if isinstance(shape, RandomWalk) else 2
    for row in range(3):
        terrain: Any = Terrain(heights, np.int32(row))  # type: ignore[arg-type]
        expected = [shape.height(terrain, *jnp.float32(place[:tangents])) for place in places[row]]
        # float32 places on slopes of 0.2 at the most.
        np.testing.assert_allclose(found[row], expected, atol=2e-6)


def test_velocity_motors_give_the_best_torques_that_trying_every_face_of_the_box_finds() -> None:
    random = np.random.default_rng(0)
    roots = random.normal(size=(300, 2, 2))
    matrices = roots @ roots.swapaxes(1, 2) + 0.1 * np.eye(2)
    wanted = random.normal(size=(300, 2)) * 10 ** random.uniform(-1, 1, (300, 1))
    law = VelocityMotor(approach=1.0, max_speed=1.0, max_torque=1.0, softness=0.0)
    limits = np.array([[-1.0, 1.0]] * 2)
    found = laws.velocity_torque(law, wanted, matrices, limits)
    best = [best_in_box(a, b, 1.0) for a, b in zip(matrices, wanted, strict=True)]
    np.testing.assert_allclose(found, best, atol=1e-10)
    assert set((np.abs(best) == 1.0).sum(axis=1).tolist()) == {0, 1, 2}


def test_a_soft_motor_falls_short_of_its_request_by_its_torque() -> None:
    law = VelocityMotor(approach=10.0, max_speed=7.0, max_torque=100.0, softness=0.5)
    asked = laws.requested(law, np.array([[0.9, -0.1]]))
    np.testing.assert_allclose(asked, [[7.0, -1.0]])
    # Alone, 3 rad/s in answer to 1 N m: a torque t gives 3 t = 7 - 0.5 t, or 3 t = -1 - 0.5 t.
    found = laws.velocity_torque(law, asked, 3.0 * np.eye(2)[None], np.array([[-9.0, 9.0]] * 2))
    np.testing.assert_allclose(found, [[2.0, -1.0 / 3.5]])
