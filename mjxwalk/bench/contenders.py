"""The engines and C MuJoCo as contenders: each takes steps for all walkers and counts them."""

import functools
from collections.abc import Callable, Collection
from typing import Any

import jax
import numpy as np

from mjxwalk.bench.bodies import Body, Workload, fixed_steps, workload
from mjxwalk.engines import lanes, lanes_xla, mjx
from mjxwalk.envs._mujoco import mujoco

# `mujoco.rollout` keeps every state that it goes through, so longer ones are run in parts.
LONGEST_ROLLOUT = 100  # steps; ours


class Engine:
    """`vmap` of one of our engines over walkers that take a fixed number of steps.

    Attributes:
      mapped: the engine's function of all walkers.
    """

    def __init__(self, vmap: Callable[..., Any], workload: Workload) -> None:
        walker = functools.partial(fixed_steps, workload.start, workload.advance)
        self.mapped = vmap(walker, (*workload.axes, None))
        self._workload = workload

    def __call__(self, steps_per_walker: int) -> int:
        """Takes the steps and returns how many all walkers took together."""
        given = self._workload
        walked = self.mapped(given.genotypes, given.given, np.int32(steps_per_walker))
        jax.block_until_ready(walked)
        return int(np.asarray(walked.steps).sum(dtype=np.int64))


class MujocoRollout:
    """C MuJoCo's `mujoco.rollout`: the same model, no controller, zero controls."""

    def __init__(self, body: Body, size: int, threads: int) -> None:
        from mujoco import rollout

        self._model = body.study().env.model.mujoco
        self._data = [mujoco.MjData(self._model) for _ in range(threads)]
        self._states = np.tile(_reference_state(self._model), (size, 1))
        pool: Any = rollout.Rollout
        self._pool = pool(nthread=threads)

    def __call__(self, steps_per_walker: int) -> int:
        """Takes the steps and returns how many all walkers took together."""
        states, taken = self._states, 0
        while taken < steps_per_walker:
            steps = min(LONGEST_ROLLOUT, steps_per_walker - taken)
            passed, _ = self._pool.rollout(self._model, self._data, states, nstep=steps)
            states = passed[:, -1]
            taken += passed.shape[1]
        return len(states) * taken


def make(
    body: Body, size: int, threads: int, *, xla: bool, without: Collection[str] = ()
) -> dict[str, Any]:
    """Returns the contenders by name.

    Args:
      body: of the walkers.
      size: of the population.
      threads: of C MuJoCo.
      xla: whether lanes-xla is one.
      without: names of contenders to leave out.
    """
    load = workload(body, size)
    field: dict[str, Callable[[], Any]] = {
        "lanes": lambda: Engine(lanes.vmap, load),
        "lanes_xla": lambda: Engine(lanes_xla.vmap, load),
        "mjx": lambda: Engine(mjx.vmap, load),
        "mujoco_rollout": lambda: MujocoRollout(body, size, threads),
    }
    left_out = {*without, *([] if xla else ["lanes_xla"])}
    return {name: ready() for name, ready in field.items() if name not in left_out}


def _reference_state(model: Any) -> Any:
    """Returns MuJoCo's state vector of a model at rest in its reference pose."""
    everything = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros(mujoco.mj_stateSize(model, everything))
    mujoco.mj_getState(model, mujoco.MjData(model), state, everything)
    return state
