"""Tests of the forces on walkers: against their weight, Coulomb's law, and what a trial counts."""

import jax.numpy as jnp
import numpy as np
import pytest
from player.given import PLANAR, SPATIAL, recorded

from mjxwalk.envs import Flame, LeggedEnv, Planar7, Reil


@pytest.mark.parametrize(
    "source", [PLANAR, pytest.param(SPATIAL, marks=pytest.mark.slow)], ids=["planar", "spatial"]
)
def test_the_ground_carries_the_body_and_changes_its_momentum(source: str) -> None:
    recording, felt, experiment = recorded(source, 1000.0, 4.0)
    steady = recording.time[:, 0] > 1.0
    upward = felt.ground[steady, :, 2].sum(axis=1)
    # Over whole strides a body's momentum is as before, so the ground gave its weight back. What
    # is left is the last stride's part.
    assert upward.mean() == pytest.approx(experiment.weight, rel=0.04)
    # No point is pulled down, and one in the air feels nothing; a step later its contact is told.
    assert (felt.ground[..., 2] >= 0).all()
    in_air = ~recording.states.touching[1:, 0]
    pushed = felt.ground[:-1][in_air].any(axis=1)
    assert in_air.sum() > 1000 and pushed.mean() < 0.002  # a depth of nothing may be rounded up
    # Coulomb's law.
    along = np.linalg.norm(felt.ground[..., :2], axis=-1)
    assert (along <= experiment.env.contact.friction * felt.ground[..., 2] * 1.001 + 1e-3).all()


def test_torques_are_what_the_trial_counts_as_cost() -> None:
    recording, felt, experiment = recorded(PLANAR, 1000.0, 1.0)
    counted = np.diff(recording.states.trial.torque_cost[:, 0].astype(np.float64))
    ours = np.abs(felt.torque[:-1]).sum(axis=1) * experiment.env.timestep
    # The cost is summed in float32, a ten-thousandth of a unit at a time.
    np.testing.assert_allclose(ours, counted, atol=2e-3, rtol=0.02)


# float32 keeps heights to 1e-7 m, so four springs of 150,000 N/m err by some 0.1 N.
@pytest.mark.parametrize(("env", "error"), [(Flame(), 0.1), (Reil(), 1.0)], ids=["sole", "spheres"])
def test_a_body_that_stands_is_borne_by_its_points(env: LeggedEnv, error: float) -> None:
    trial = env.level_trials().given(jnp.zeros((), jnp.int32))
    pushes = np.asarray(env.ground_forces(env.reset(trial), trial))
    assert pushes.shape == (len(env.anatomy.points), 3)
    upward = pushes[:, 2].sum()
    assert upward == pytest.approx(env.weight, abs=error)


def test_a_body_whose_soles_just_touch_is_not_borne() -> None:
    env = Planar7()
    trial = env.level_trials().given(jnp.zeros((), jnp.int32))
    pushes = np.asarray(env.ground_forces(env.reset(trial), trial))
    assert pushes.shape == (4, 3) and np.abs(pushes).max() < 0.01 * env.weight
