"""One genotype on one terrain: the function that every engine runs for a whole population."""

from typing import Any, NamedTuple

import jax
from jaxtyping import Array, Bool, Float, Int

from mjxwalk.controllers import LinearReactive
from mjxwalk.envs import Planar7, Terrain


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


def rollout(env: Planar7, controller: LinearReactive, genotype: Any, terrain: Terrain) -> Outcome:
    """Returns how far one walker gets before it falls or has spent its budget.

    Solomon et al. (2013), section 2.7.2: fitness is the distance that a walker travels until then.
    """

    def walking(carry: tuple[Any, Any]) -> Bool[Array, ""]:
        state, _ = carry
        return ~state.done

    def step(carry: tuple[Any, Any]) -> tuple[Any, Any]:
        state, memory = carry
        memory, action = controller.act(genotype, memory, env.observe(state))
        return env.step(state, action, terrain), memory

    start = (env.reset(terrain), controller.init(genotype))
    state, _ = jax.lax.while_loop(walking, step, start)
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
