"""A task of my own: a mass on a springy leg learns to hop forward.

Evolve it with `mjxwalk evolve FILE`; any setting below is changed by, say, `--set env.mass=2`.
Everything is written for one walker. Functions of the walker are traced once by JAX and then run
for thousands at a time, so they must be pure: use jax.numpy, and jnp.where in place of `if`.
"""

import dataclasses
from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.controllers import LinearFeedback
from mjxwalk.envs import FlatEnv, TrialState
from mjxwalk.experiments.experiment import Experiment, StrategyChoice


class State(NamedTuple):
    """All that changes in a trial; `step` returns a new one, of the same shapes and types."""

    qpos: Float[Array, "2"]  # forward, up; m. The first number is the distance that is reported
    qvel: Float[Array, "2"]  # m/s
    effort: Float[Array, ""]  # N s so far
    trial: TrialState  # what ends the trial


@dataclasses.dataclass(frozen=True, kw_only=True)
class Hopper(FlatEnv):
    """The settings of the task; a run keeps them, so that they are numbers, texts, or lists."""

    observation_names = ("height", "speed forward", "speed up", "on the ground")
    action_names = ("push", "lean")
    num_draws = 1  # random numbers from -1 to 1 that differ between trials

    timestep: float = 0.01  # s
    max_time: float = 10.0  # s
    mass: float = 1.0  # kg
    leg: float = 1.0  # m, its length when nothing presses it
    stiffness: float = 400.0  # N/m
    push: float = 20.0  # N, that the leg can add to its spring
    drag: float = 0.2  # N s/m, of the air
    price: float = 0.001  # m for each N s of effort

    def reset(self, given: Any, /) -> State:
        """Returns the state that a trial starts in."""
        height = self.leg * (1.2 + 0.1 * given.start[0])
        still = jnp.zeros(2)
        return State(jnp.array([0.0, height]), still, jnp.zeros(()), TrialState.begin())

    def observe(self, state: State, /) -> Float[Array, "4"]:
        """Returns what the walker senses: a number for each of `observation_names`."""
        height = state.qpos[1]
        return jnp.stack([height - self.leg, state.qvel[0], state.qvel[1], 1.0 * self._on(height)])

    def step(self, state: State, action: Float[Array, "2"], given: Any, /) -> State:
        """Returns the state one step later; an action is a number from -1 to 1 for each name."""
        push, lean = action[0], action[1]
        pressed = jnp.maximum(self.leg - state.qpos[1], 0.0)
        force = self._on(state.qpos[1]) * (self.stiffness * pressed + self.push * push)
        force = jnp.maximum(force, 0.0)  # the ground does not pull
        # Who leans on the leg is pushed forward, and the faster it already is the less.
        pushed = jnp.stack([(0.1 * lean - 0.02 * state.qvel[0]) * force, force])
        rate = (pushed - self.drag * state.qvel) / self.mass - jnp.array([0.0, 9.81])
        qvel = state.qvel + self.timestep * rate
        qpos = state.qpos + self.timestep * qvel
        effort = state.effort + self.timestep * jnp.abs(self.push * push)
        fell = qpos[1] < 0.5 * self.leg
        return State(qpos, qvel, effort, self.count(state.trial, fell=fell))

    def fitness(self, state: State, /) -> Float[Array, ""]:
        """Returns what the walker is worth at the end of its trial; higher is better."""
        return state.qpos[0] - self.price * state.effort

    def _on(self, height: Float[Array, ""]) -> Any:
        return height < self.leg


TASK = Experiment(
    name="hopper",
    env=Hopper(),
    controller=LinearFeedback(),  # or Mlp(hidden=(16,)), or RecurrentNetwork()
    strategy=StrategyChoice(name="snes", options={"sigma": 0.5}),  # docs/strategies.md has others
    population_size=64,
    generations=50,
    terrains_per_evaluation=2,  # trials of each walker, from different heights
)
