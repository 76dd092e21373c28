"""What motors and ground do to a walker in each frame of a recording."""

import dataclasses
import functools
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from mjxwalk import engines
from mjxwalk.envs import LeggedEnv, Trial
from mjxwalk.replay import Recording
from mjxwalk.rollout import Controller


class Forces(NamedTuple):
    """Forces on one walker, in a frame or in many.

    Attributes:
      torque: of the motors, N m, in the order of an action.
      ground: on the points of the feet, N, in the order of the anatomy's points; x, y and z.
    """

    torque: Float[Any, "*frame motor"]
    ground: Float[Any, "*frame point 3"]


def measure(
    env: LeggedEnv,
    controller: Controller,
    genotype: Any,
    given: Trial,
    recording: Recording,
    walker: int,
) -> Forces:
    """Returns the forces on one of the walkers in all frames; numpy.

    Args:
      env: that the recording is of.
      controller: that drove the walkers.
      genotype: of the one walker.
      given: the trials that all walkers were recorded in.
      recording: with memories.
      walker: its place in it.
    """
    states, memories = (
        jax.tree.map(lambda leaf: np.ascontiguousarray(leaf[:, walker]), each)
        for each in (recording.states, recording.memories)
    )
    mapped = _compiled(_Walker(env, controller), engines.choose("auto").name)
    alone = given._replace(ground=given.ground.row)
    own = jax.tree.map(lambda leaf: np.asarray(leaf)[walker], alone)
    own = own._replace(ground=given.ground._replace(row=own.ground))
    found = mapped(states, memories, genotype, own)
    return jax.tree.map(np.asarray, found)


@dataclasses.dataclass(frozen=True)
class _Walker:
    """A body and what drives it: the settings of the function that engines compile."""

    env: LeggedEnv
    controller: Controller

    def forces(self, state: Any, memory: Any, genotype: Any, given: Trial) -> Forces:
        """Returns the forces on a walker in a state."""
        _, action = self.controller.act(genotype, memory, self.env.observe(state))
        torque = self.env.motor_torques(state, action, given)
        return Forces(torque, self.env.ground_forces(state, given))


@functools.lru_cache(maxsize=8)
def _compiled(walker: _Walker, engine: str) -> Any:
    axes = (0, 0, None, None)
    return engines.load(engine).vmap(walker.forces, axes, results=Forces(torque=0, ground=1))
