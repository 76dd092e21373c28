"""Tests of how the hip-powered biped is shown."""

import jax.numpy as jnp
import numpy as np

from mjxwalk.envs import Reil, Terrain, TrialVariation
from mjxwalk.envs.reil_trials import usual
from mjxwalk.watch import bodies, ending, forces, grounds

ENV = Reil()
FLAT = Terrain(usual(), jnp.zeros((), jnp.int32))


def test_a_body_that_stands_is_borne_by_its_spheres() -> None:
    pushes = np.asarray(forces.ground_forces(ENV, ENV.reset(FLAT), FLAT))
    assert pushes.shape == (4, 3)
    # float32 keeps heights to 1e-7 m, so four springs of 150,000 N/m err by some 0.1 N.
    np.testing.assert_allclose(pushes.sum(axis=0), [0.0, 0.0, ENV.weight], atol=1.0)


def test_every_part_of_the_body_is_there_to_draw() -> None:
    body = bodies.describe(ENV)
    assert {part.shape for part in body.parts} == {"box", "sphere"} and len(body.parts) == 11
    assert [point.side for point in body.points] == ["left", "left", "right", "right"]
    lines = [point for stick in body.sticks for point in stick.line]
    assert np.isfinite(lines).all()
    driven = [angle.name for angle in body.angles if angle.motor is not None]
    assert driven == ["hip", "hip"]


def test_the_ground_rises_as_the_trial_drew_it() -> None:
    draws = np.array([0.0, 0.0, 0.0, 0.0, 0.0, -0.5], np.float32)
    qpos = np.zeros((2, 1, 14))
    qpos[1, 0, :2] = 20.0, 4.0
    slope = TrialVariation(slope=0.1)
    ground, rows = grounds.around(slope, draws, qpos)
    assert ground.width > 8.0  # to where it drifts
    np.testing.assert_allclose(grounds.height(ground, rows, qpos[1, 0]), -1.0)


def test_the_end_of_a_trial_is_told_by_its_rule() -> None:
    state = ENV.reset(FLAT)._replace(done=jnp.ones((), bool))
    there = state._replace(qpos=state.qpos.at[0].set(20.5))
    assert ending.explain(ENV, there, 0.0).text == "came to 20 m, where trials end"
    low = state._replace(fell=jnp.ones((), bool), height=jnp.float32(0.5))
    assert ending.explain(ENV, low, 0.0).text.startswith("fell: centre of mass lower than 80%")
    turned = low._replace(qpos=state.qpos.at[3].set(1.2))
    assert ending.explain(ENV, turned, 0.0).text == "fell: turned off its course"
