"""A task without a body: a mass on a rail is pushed, and its observation is an array."""

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.envs import Trial, Trials, TrialState


class CartState(NamedTuple):
    """Where it is and how fast, and what its trial counts."""

    qpos: Float[Array, "1"]
    qvel: Float[Array, "1"]
    trial: TrialState


@dataclasses.dataclass(frozen=True, kw_only=True)
class Cart:
    """The mass, and a trial of some steps; its fitness is how far it came."""

    timestep: float = 0.05
    steps: int = 20
    friction: float = 0.5

    observation_names = ("place", "speed", "always 3")
    action_names = ("push",)

    def sample_trials(self, key: PRNGKeyArray, num: int, roughness: float | None = None) -> Trials:
        """Returns trials that start anywhere within a metre."""
        del roughness
        start = jax.random.uniform(key, (num, 1), minval=-1.0, maxval=1.0)
        return Trials(np.zeros((num, 1), np.float32), start)

    def reset(self, given: Trial) -> CartState:
        """Returns the mass at rest."""
        return CartState(jnp.asarray(given.start), jnp.zeros(1), TrialState.begin())

    def observe(self, state: CartState) -> Float[Array, "3"]:
        """Returns place, speed and a number that never changes."""
        return jnp.concatenate([state.qpos, state.qvel, jnp.full(1, 3.0)])

    def step(self, state: CartState, action: Any, given: Trial) -> CartState:
        """Returns the mass a step later."""
        del given
        qvel = state.qvel + self.timestep * (action - self.friction * state.qvel)
        num = state.trial.num_steps + 1
        trial = state.trial._replace(num_steps=num, done=num >= self.steps)
        return CartState(state.qpos + self.timestep * qvel, qvel, trial)

    def fitness(self, state: CartState) -> Float[Array, ""]:
        """Returns how far it is."""
        return state.qpos[0]
