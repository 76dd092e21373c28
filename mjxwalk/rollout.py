"""One genotype in one trial: the function that every engine runs for a whole population."""

from typing import Any, NamedTuple, Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from mjxwalk.controllers import Controller, action_noise
from mjxwalk.envs import Trials, TrialState


@runtime_checkable
class Environment(Protocol):
    """A body, its ground and the rules of a trial; every `mjxwalk.envs.LeggedEnv` is one.

    Observations and actions are types of their own. States have `qpos`, whose first coordinate is
    how far the walker has come, m, and a `mjxwalk.envs.TrialState` as `trial`.
    """

    @property
    def timestep(self) -> float:
        """Of the physics, s."""
        ...

    def sample_trials(self, key: PRNGKeyArray, num: int, roughness: float | None = None) -> Trials:
        """Returns independent trials; on ground of its own roughness if none is given, m."""
        ...

    def reset(self, given: Any, /) -> Any:
        """Returns the state that a trial starts in."""
        ...

    def observe(self, state: Any, /) -> Any:
        """Returns what the walker senses."""
        ...

    def step(self, state: Any, action: Any, given: Any, /) -> Any:
        """Returns the state one step later."""
        ...

    def fitness(self, state: Any, /) -> Float[Array, ""]:
        """Returns the fitness of a walker whose trial has ended; higher is better."""
        ...


class Outcome(NamedTuple):
    """What a walker did in one trial.

    Attributes:
      fitness: higher is better; the distance, m, or what the environment says.
      distance: of the hip from where it started, forward, m.
      duration: s.
      fell: whether the trial ended by a fall, or by physics that diverged.
      diverged: whether the physics diverged; all else is then as of the last sound state.
      torque_cost: integral of the joints' summed absolute torque, N m s.
      work: integral of the joints' summed absolute power, J.
      steps: of the physics.
      sensed: `mjxwalk.controllers.normalisation.Sums` of what it sensed; None of a controller that
        does not normalise its senses.
    """

    fitness: Float[Array, "*batch"]
    distance: Float[Array, "*batch"]
    duration: Float[Array, "*batch"]
    fell: Bool[Array, "*batch"]
    diverged: Bool[Array, "*batch"]
    torque_cost: Float[Array, "*batch"]
    work: Float[Array, "*batch"]
    steps: Int[Array, "*batch"]
    sensed: Any = None


@runtime_checkable
class TrialRunner(Protocol):
    """Runs the trials of a population: every genotype in every trial."""

    def evaluate(self, population: Any, trials: Trials, /) -> Outcome:
        """Returns the outcomes as numpy arrays [pop, trial]."""
        ...


class Walk(NamedTuple):
    """A walker in the middle of a trial.

    Attributes:
      state: the environment's.
      memory: the controller's.
    """

    state: Any
    memory: Any


def start(env: Environment, controller: Controller, genotype: Any, given: Any) -> Walk:
    """Returns a walker at the start of a trial."""
    return Walk(env.reset(given), controller.init(genotype))


def advance(
    env: Environment, controller: Controller, genotype: Any, given: Any, walk: Walk
) -> Walk:
    """Returns the walker after one step of control and physics."""
    memory, action = _act(env, controller, genotype, given, walk)
    return Walk(env.step(walk.state, action, given), memory)


def _act(
    env: Environment, controller: Controller, genotype: Any, given: Any, walk: Walk
) -> tuple[Any, Any]:
    """Returns the controller's next memory and its action, with the noise of the trial."""
    memory, action = controller.act(genotype, walk.memory, env.observe(walk.state))
    deviation, seed = getattr(env, "action_noise", 0.0), getattr(given, "noise", None)
    if not deviation or seed is None:
        return memory, action
    # All steps for which an action stays the same have the same noise.
    turn = jax.lax.div(walk.state.trial.num_steps, np.int32(controller.steps_per_action()))
    return memory, action_noise.noisy(action, deviation, seed, turn)


def _hold(env: Environment, controller: Controller, genotype: Any, given: Any, walk: Walk) -> Walk:
    """Returns the walker when its next action is due: `advance` as often as the action is held."""
    memory, action = _act(env, controller, genotype, given, walk)

    def holding(at: tuple[Any, Any]) -> Bool[Array, ""]:
        return (at[0] < controller.steps_held()) & ~at[1].trial.done

    def step(at: tuple[Any, Any]) -> tuple[Any, Any]:
        return at[0] + 1, env.step(at[1], action, given)

    _, state = jax.lax.while_loop(holding, step, (jnp.zeros((), jnp.int32), walk.state))
    return Walk(state, controller.held(memory))


def rollout(env: Environment, controller: Controller, genotype: Any, given: Any) -> Outcome:
    """Returns how far one walker gets before it falls or has spent its budget.

    Solomon et al. (2013), section 2.7.2: fitness is the distance that a walker travels until then,
    unless the environment has one of its own.
    """

    def walking(walk: Walk) -> Bool[Array, ""]:
        return ~walk.state.trial.done

    def step(walk: Walk) -> Walk:
        if controller.steps_held() == 1:
            return advance(env, controller, genotype, given, walk)
        return _hold(env, controller, genotype, given, walk)

    end = jax.lax.while_loop(walking, step, start(env, controller, genotype, given))
    state = end.state
    trial: TrialState = state.trial
    return Outcome(
        fitness=env.fitness(state),
        distance=state.qpos[0],
        duration=trial.num_steps * env.timestep,
        fell=trial.fell,
        diverged=trial.diverged,
        torque_cost=trial.torque_cost,
        work=trial.work,
        steps=trial.num_steps,
        sensed=controller.sensed(end.memory),
    )
