"""C MuJoCo as a contender: `mujoco.batch`, and `mujoco.rollout`."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from mjxwalk.bench.bodies import PointBody
from mjxwalk.bench.contact_bodies import HELD, ContactBody
from mjxwalk.envs._mujoco import mujoco

# `mujoco.rollout` keeps every state that it goes through, so longer ones are run in parts.
LONGEST_ROLLOUT = 100  # steps; ours
SIZE = 256  # walkers of a closed loop; ours: C MuJoCo is as fast with more, and a trial ends sooner

Makers = dict[str, Callable[[], Any]]


class Observed(NamedTuple):
    """What C MuJoCo met in a trial.

    Attributes:
      contacts: active ones of a walker, on the average.
      warnings: of simulations that became unstable, which C MuJoCo then starts anew.
    """

    contacts: float
    warnings: int


def of_points(body: PointBody, size: int, threads: int) -> Makers:
    """Returns C MuJoCo's contenders beside our contact points, by name."""
    if body.peer is not None:
        return of_contacts(body.peer(), threads)
    model = body.study().env.model.mujoco
    return {
        "mujoco_batch": lambda: FreeBatch(model, size, threads),
        "mujoco_rollout": lambda: FreeRollout(model, size, threads),
    }


def of_contacts(body: ContactBody, threads: int) -> Makers:
    """Returns C MuJoCo's contenders with contacts, by name."""
    return {
        "mujoco_batch": lambda: ClosedLoop(body, SIZE, threads),
        "mujoco_rollout": lambda: Replay(body, SIZE, threads),
    }


class FreeBatch:
    """`mujoco.batch` of a model as it is, without control."""

    def __init__(self, model: Any, size: int, threads: int) -> None:
        from mujoco import batch

        self._batch: Any = batch.Batch(model, size, threads)

    def __call__(self, steps_per_walker: int) -> int:
        """Takes the steps and returns how many all walkers took together."""
        self._batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE)
        self._batch.step(nstep=steps_per_walker)
        return self._batch.nsim * steps_per_walker


class FreeRollout:
    """`mujoco.rollout` of a model as it is, without control."""

    def __init__(self, model: Any, size: int, threads: int) -> None:
        from mujoco import rollout

        self._model = model
        self._data = [mujoco.MjData(self._model) for _ in range(threads)]
        self._states = np.tile(state_of(self._model, mujoco.MjData(self._model)), (size, 1))
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


class ClosedLoop:
    """`mujoco.batch` with the policies in the loop: they see, and C MuJoCo takes `HELD` steps."""

    def __init__(self, body: ContactBody, size: int, threads: int) -> None:
        from mujoco import batch

        self._body = body
        self._genotypes = body.genotypes(size)
        self.model = body.c_model()
        self._batch: Any = batch.Batch(self.model, size, threads)
        self._qpos, self._qvel, self._ctrl = map(self._batch.bind, ("qpos", "qvel", "ctrl"))
        starts = body.starts(size)
        self._qpos[:], self._qvel[:] = starts.qpos, starts.qvel
        self.states = self._batch.state.copy()  # at the start

    def __call__(self, times: int) -> int:
        """Walks that many trials and returns how many steps all walkers took together."""
        for _ in range(times):
            self._batch.state[:] = self.states
            for _ in range(self._body.num_actions):
                self._act()
        return times * self._batch.nsim * self._body.num_actions * HELD

    def controls(self) -> Any:
        """Returns the controls of a trial [walker, step of control, motor]."""
        self._batch.state[:] = self.states
        return np.stack([self._act() for _ in range(self._body.num_actions)], axis=1)

    def observe(self) -> Observed:
        """Returns what C MuJoCo meets in a trial; later ones are slower by what it looks at."""
        contacts = self._batch.bind("ncon")
        self._batch.warning[:] = 0
        self._batch.state[:] = self.states
        found: list[float] = []
        for _ in range(self._body.num_actions):
            self._act()
            found.append(float(contacts.mean()))
        return Observed(float(np.mean(found)), int(self._batch.warning[..., 1].sum()))

    def walked(self, num_actions: int) -> tuple[Any, Any]:
        """Returns positions and velocities after so many steps of control."""
        self._batch.state[:] = self.states
        for _ in range(num_actions):
            self._act()
        return self._qpos.copy(), self._qvel.copy()

    def _act(self) -> Any:
        ctrl = self._body.controls(self._genotypes, self._qpos, self._qvel)
        self._ctrl[:] = ctrl
        self._batch.step(nstep=HELD)
        return ctrl


class Replay:
    """`mujoco.rollout` of the same trials: it knows no loop, so the controls are given."""

    def __init__(self, body: ContactBody, size: int, threads: int) -> None:
        from mujoco import rollout

        loop = ClosedLoop(body, size, threads)
        self._model = loop.model
        self._controls = np.repeat(loop.controls().astype(float), HELD, axis=1)
        data = mujoco.MjData(self._model)
        self._data = [mujoco.MjData(self._model) for _ in range(threads)]
        starts = body.starts(size)
        states: list[Any] = []
        for qpos, qvel in zip(starts.qpos, starts.qvel, strict=True):
            data.qpos[:], data.qvel[:] = qpos, qvel
            states.append(state_of(self._model, data))
        self._states = np.array(states)
        shape = (size, self._controls.shape[1], self._states.shape[1])
        self._passed = np.empty(shape)  # kept, so that no time goes into making it
        pool: Any = rollout.Rollout
        self._pool = pool(nthread=threads)

    def __call__(self, times: int) -> int:
        """Walks that many trials and returns how many steps all walkers took together."""
        for _ in range(times):
            self._pool.rollout(
                self._model, self._data, self._states, self._controls, state=self._passed
            )
        return times * self._passed.shape[0] * self._passed.shape[1]


def state_of(model: Any, data: Any) -> Any:
    """Returns MuJoCo's state vector of a model's data."""
    everything = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros(mujoco.mj_stateSize(model, everything))
    mujoco.mj_getState(model, data, state, everything)
    return state
