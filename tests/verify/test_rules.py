"""Tests of the rules of trials: one in C MuJoCo ends where they say, and as the engine's does."""

import dataclasses
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from verify.stepped import BODIES, shorter, started

from mjxwalk.controllers import Controller
from mjxwalk.envs import HipTargets, SoftContact
from mjxwalk.rollout import Outcome
from mjxwalk.verify import comparing, trials
from mjxwalk.verify.reference import Reference
from mjxwalk.verify.rules import standing_height


def in_c_mujoco(name: str = "planar-lpd", **rules: Any) -> Outcome:
    walker = shorter(name, **({"max_time": 1.0} | rules))
    env = walker.experiment.env
    return trials.run(env, walker.experiment.controller, walker.genotype, env.level_trials())


def test_a_trial_ends_where_its_rules_say() -> None:
    late = in_c_mujoco(max_time=0.1)
    assert (late.duration, late.steps, late.fell) == (pytest.approx(0.1), 100, False)
    assert late.fitness == late.distance
    spent = in_c_mujoco(torque_budget=20.0)
    assert 20.0 <= spent.torque_cost < 22.0 and not spent.fell  # a step costs 0.3 to 2 N m s
    behind = in_c_mujoco(max_lag=0.1, min_speed=5.0)
    lag = 5.0 * behind.duration - behind.distance
    assert 0.1 < lag < 0.106 and not behind.fell  # 5 mm a step
    low = in_c_mujoco(min_hip_height=1.0)
    assert low.steps == 1 and low.fell


def test_a_trial_ends_where_a_body_s_own_rules_say() -> None:
    arrived = in_c_mujoco("reil", max_distance=0.1)
    assert 0.1 <= arrived.fitness < 0.11 and not arrived.fell
    assert arrived.distance != arrived.fitness  # which the hindmost ankle gives
    low = in_c_mujoco("reil", min_height=0.999)
    assert 1 <= low.steps < 100 and low.fell and low.fitness == 0.0
    turned = in_c_mujoco("reil", max_yaw=0.001, fallen_distance=0.0)
    assert turned.fell and turned.duration < 1.0 and turned.fitness != turned.distance


@dataclasses.dataclass(frozen=True)
class Asking(Controller):
    """A controller that asks the hips for one angle more with every of its first steps."""

    steps: int

    def template(self) -> dict[str, Any]:
        """Returns nothing."""
        return {}

    def init(self, genotype: Any, /) -> Any:
        """Returns the number of steps so far."""
        return jnp.zeros(())

    def act(self, genotype: Any, memory: Any, observation: Any, /) -> tuple[Any, HipTargets]:
        """Returns one more step, and the angles."""
        angle = 0.01 * jnp.minimum(memory + 1.0, self.steps)
        return memory + 1.0, HipTargets(jnp.stack([angle, angle]))


def test_a_trial_ends_when_what_is_asked_stands_still() -> None:
    env = shorter("reil", max_still_time=0.1).experiment.env
    outcome = trials.run(env, Asking(10), {}, env.level_trials())
    # Ten steps ask for something new, then it is 51 until the time is above 0.1 s, or 50 as 0.1 is
    # no sum of float64s of 0.002.
    assert outcome.steps in (60, 61) and not outcome.fell


def test_a_run_that_diverges_ends_so() -> None:
    outcome = in_c_mujoco(integrator="explicit", contact=SoftContact(damping=1e6))
    assert outcome.diverged.all() and outcome.fell.all()
    assert np.isfinite(outcome.work).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "rules"),
    [
        ("planar-lpd", {"min_hip_height": 0.91}),
        ("planar-lpd", {"max_pitch": 0.03}),
        ("reil", {"min_height": 0.985}),
        ("reil", {"max_yaw": 0.02}),
    ],
)
def test_falls_come_at_the_same_step(name: str, rules: dict[str, float]) -> None:
    walker = shorter(name, max_time=1.0, **rules)
    found = comparing.verify(walker, engine="lanes", terrains=1, seed=2, say=print)
    assert found.reference.fell == found.engine.fell == (True,)
    # Where a threshold is met on the flat of a curve, rounding moves it by a few steps.
    np.testing.assert_allclose(found.engine.duration_s, found.reference.duration_s, atol=5e-3)
    assert 0.02 < found.reference.duration_s[0] < 0.9


def test_a_body_stands_as_high_as_its_environment_has_it() -> None:
    env = BODIES["hip-powered"]
    trial, states = started(env)
    reference = Reference(env, [states[0].qpos], [states[0].qvel], trial.take(slice(1)))
    assert standing_height(reference) == pytest.approx(float(states[0].own.height), abs=1e-6)
