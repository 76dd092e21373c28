"""An environment of arrays counts its trials as `FlatEnv` says."""

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array, Float

from mjxwalk.envs import FlatEnv, TrialState


class State(NamedTuple):
    """A falling mass."""

    qpos: Float[Array, "1"]
    speed: Float[Array, ""]
    trial: TrialState


@dataclasses.dataclass(frozen=True, kw_only=True)
class Falling(FlatEnv):
    """Falls 1 m."""

    observation_names = ("height",)
    action_names = ("push",)
    num_draws = 2

    def reset(self, given: Any, /) -> State:
        """Returns the mass at rest."""
        return State(jnp.zeros(1), jnp.zeros(()), TrialState.begin())

    def observe(self, state: State, /) -> Float[Array, "1"]:
        """Returns how far it fell."""
        return state.qpos

    def step(self, state: State, action: Any, given: Any, /) -> State:
        """Returns the mass a step later."""
        speed = state.speed + 9.81 * self.timestep
        qpos = state.qpos + self.timestep * speed
        return State(qpos, speed, self.count(state.trial, fell=qpos[0] > 1.0))


def steps_until_done(env: Falling) -> State:
    given = env.sample_trials(jax.random.key(0), 1).given(0)
    state = env.reset(given)
    while not bool(state.trial.done):
        state = env.step(state, jnp.zeros(1), given)
    return state


def test_a_trial_ends_by_a_fall_after_the_time_that_physics_gives() -> None:
    state = steps_until_done(Falling(timestep=0.001))
    assert bool(state.trial.fell)
    # A fall of 1 m takes the root of 2 / 9.81 s; the integrator is semi-implicit, of first order.
    np.testing.assert_allclose(int(state.trial.num_steps) * 0.001, np.sqrt(2 / 9.81), atol=0.002)
    assert float(Falling().fitness(state)) == float(state.qpos[0])


def test_a_trial_ends_after_its_longest_time() -> None:
    state = steps_until_done(Falling(timestep=0.01, max_time=0.2))
    assert not bool(state.trial.fell) and int(state.trial.num_steps) == 20


def test_trials_differ_by_their_draws() -> None:
    trials = Falling().sample_trials(jax.random.key(0), 100)
    assert trials.num == 100 and trials.start.shape == (100, 2)
    assert float(abs(trials.start).max()) <= 1.0 and len(np.unique(trials.start)) == 200


def test_a_time_step_below_zero_is_refused() -> None:
    with pytest.raises(ValueError, match="timestep must be a number above 0"):
        Falling(timestep=-1.0)
