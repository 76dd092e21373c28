"""One genotype on one terrain: the function that every engine runs for a whole population."""

from typing import Any, NamedTuple

import jax
from jaxtyping import Array, Bool, Float, Int

from mjxwalk.controllers import LinearReactive, Memory
from mjxwalk.envs import Planar7, State, Terrain


class Outcome(NamedTuple):
    """What a walker did in one trial.

    Attributes:
      fitness: higher is better; the distance, m.
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
    """A walker in the middle of a trial: its body and its controller's memory."""

    state: State
    memory: Memory


def start(env: Planar7, controller: LinearReactive, genotype: Any, terrain: Terrain) -> Walk:
    """Returns a walker at the start of a trial."""
    return Walk(env.reset(terrain), controller.init(genotype))


def advance(
    env: Planar7, controller: LinearReactive, genotype: Any, terrain: Terrain, walk: Walk
) -> Walk:
    """Returns the walker after one step of control and physics."""
    memory, action = controller.act(genotype, walk.memory, env.observe(walk.state))
    return Walk(env.step(walk.state, action, terrain), memory)


def rollout(env: Planar7, controller: LinearReactive, genotype: Any, terrain: Terrain) -> Outcome:
    """Returns how far one walker gets before it falls or has spent its budget.

    Solomon et al. (2013), section 2.7.2: fitness is the distance that a walker travels until then.
    """

    def walking(walk: Walk) -> Bool[Array, ""]:
        return ~walk.state.done

    def step(walk: Walk) -> Walk:
        return advance(env, controller, genotype, terrain, walk)

    state = jax.lax.while_loop(walking, step, start(env, controller, genotype, terrain)).state
    return Outcome(
        fitness=state.qpos[0],
        distance=state.qpos[0],
        duration=state.num_steps * env.timestep,
        fell=state.fell,
        diverged=state.diverged,
        torque_cost=state.torque_cost,
        work=state.work,
        steps=state.num_steps,
    )
