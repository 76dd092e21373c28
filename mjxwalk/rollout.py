"""One genotype on one terrain: the function that every engine runs for a whole population."""

from typing import Any, NamedTuple, Protocol, runtime_checkable

import jax
from jaxtyping import Array, Bool, Float, Int


@runtime_checkable
class Trial(Protocol):
    """What an outcome is read from in an environment's state, whatever else that holds.

    `Planar7`'s state says what each is; the first coordinate is the hip's x, m.
    """

    @property
    def qpos(self) -> Float[Array, " coordinate"]: ...
    @property
    def num_steps(self) -> Int[Array, ""]: ...
    @property
    def torque_cost(self) -> Float[Array, ""]: ...
    @property
    def work(self) -> Float[Array, ""]: ...
    @property
    def fell(self) -> Bool[Array, ""]: ...
    @property
    def diverged(self) -> Bool[Array, ""]: ...
    @property
    def done(self) -> Bool[Array, ""]: ...


@runtime_checkable
class Environment(Protocol):
    """A body, its ground and the rules of a trial; `Planar7` and `Flame` are.

    Their states, observations, actions and grounds are types of their own.
    """

    @property
    def timestep(self) -> float:
        """Of the physics, s."""
        ...

    def reset(self, ground: Any, /) -> Trial:
        """Returns the state that a trial starts in."""
        ...

    def observe(self, state: Any, /) -> Any:
        """Returns what the walker senses."""
        ...

    def step(self, state: Any, action: Any, ground: Any, /) -> Trial:
        """Returns the state one step later."""
        ...


@runtime_checkable
class Judging(Protocol):
    """An environment that has a fitness of its own, other than the distance of the hip."""

    def fitness(self, state: Any, /) -> Float[Array, ""]:
        """Returns the fitness of a walker whose trial has ended; higher is better."""
        ...


@runtime_checkable
class Controller(Protocol):
    """What drives the body of an environment; `LinearReactive` does so for `Planar7`."""

    def init(self, genotype: Any, /) -> Any:
        """Returns the memory at the start of a trial, a pytree."""
        ...

    def act(self, genotype: Any, memory: Any, observation: Any, /) -> tuple[Any, Any]:
        """Returns the new memory and the action."""
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
    """

    fitness: Float[Array, "*batch"]
    distance: Float[Array, "*batch"]
    duration: Float[Array, "*batch"]
    fell: Bool[Array, "*batch"]
    diverged: Bool[Array, "*batch"]
    torque_cost: Float[Array, "*batch"]
    work: Float[Array, "*batch"]
    steps: Int[Array, "*batch"]


class Walk(NamedTuple):
    """A walker in the middle of a trial.

    Attributes:
      state: the environment's, a `Trial`.
      memory: the controller's.
    """

    state: Any
    memory: Any


def start(env: Environment, controller: Controller, genotype: Any, terrain: Any) -> Walk:
    """Returns a walker at the start of a trial."""
    return Walk(env.reset(terrain), controller.init(genotype))


def advance(
    env: Environment, controller: Controller, genotype: Any, terrain: Any, walk: Walk
) -> Walk:
    """Returns the walker after one step of control and physics."""
    memory, action = controller.act(genotype, walk.memory, env.observe(walk.state))
    return Walk(env.step(walk.state, action, terrain), memory)


def rollout(env: Environment, controller: Controller, genotype: Any, terrain: Any) -> Outcome:
    """Returns how far one walker gets before it falls or has spent its budget.

    Solomon et al. (2013), section 2.7.2: fitness is the distance that a walker travels until then,
    unless the environment is `Judging`.
    """

    def walking(walk: Walk) -> Bool[Array, ""]:
        return ~walk.state.done

    def step(walk: Walk) -> Walk:
        return advance(env, controller, genotype, terrain, walk)

    state: Trial = jax.lax.while_loop(
        walking, step, start(env, controller, genotype, terrain)
    ).state
    return Outcome(
        fitness=env.fitness(state) if isinstance(env, Judging) else state.qpos[0],
        distance=state.qpos[0],
        duration=state.num_steps * env.timestep,
        fell=state.fell,
        diverged=state.diverged,
        torque_cost=state.torque_cost,
        work=state.work,
        steps=state.num_steps,
    )
