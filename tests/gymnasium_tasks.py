"""Steps of Gymnasium's own tasks, C MuJoCo in float64, to compare with.

    JAX_ENABLE_X64=1 python gymnasium_tasks.py Walker2d-v5

prints the largest difference of a position after a hundred control steps, both in float64.
"""

import os
import sys
from typing import Any, NamedTuple, cast

import gymnasium
import jax
import numpy as np

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.gymnasium import TASKS, GymnasiumTask, TaskState, Told
from mjxwalk.envs.trial import TrialState


class Steps(NamedTuple):
    """States before a control step, actions, and what Gymnasium returns; all [step, ...]."""

    before: TaskState
    action: Any
    qpos: Any
    qvel: Any
    observation: Any
    reward: Any
    terminated: Any


def make(task: GymnasiumTask) -> Any:
    """Returns Gymnasium's environment with a solver that converges, and nothing around it."""
    env: Any = gymnasium.make(task.ID).unwrapped
    env.model.opt.solver = mujoco.mjtSolver.mjSOL_NEWTON  # of Humanoid it is another
    env.model.opt.iterations, env.model.opt.ls_iterations = 200, 50
    env.model.opt.tolerance = 1e-15
    return env


def state_of(task: GymnasiumTask, data: Any) -> TaskState:
    """Returns the task's state that MuJoCo's data hold."""
    found: dict[str, Any] = {
        "ahead": np.array(float(task.place(_Axes(data))) - data.qpos[0]),
        "cinert": data.cinert,
        "cvel": data.cvel,
        "qfrc_actuator": data.qfrc_actuator,
        "cfrc_ext": data.cfrc_ext,
    }
    values: dict[str, Any] = {name: np.array(found[name]) for name in task.TOLD}
    told, count = Told(**values), cast("Any", np.zeros((), np.int32))
    zero, no = cast("Any", np.zeros(())), cast("Any", np.zeros((), bool))
    trial = TrialState(count, zero, zero, zero, no, no, no)
    names = "qpos", "qvel", "qacc_warmstart"
    qpos, qvel, near = (cast("Any", np.array(getattr(data, name))) for name in names)
    return TaskState(qpos, qvel, near, told, zero, trial)


class _Axes:
    """MuJoCo's data with places, as MJX's have them."""

    def __init__(self, data: Any) -> None:
        self.qpos, self.xpos = data.qpos, data.xpos
        self.subtree_com = data.subtree_com


def steps(task: GymnasiumTask, *, episodes: int, length: int, scale: float) -> Steps:
    """Returns every step of episodes with random actions, each held for some steps.

    Args:
      task: to compare with Gymnasium's.
      episodes: how many; those after the end of a trial are left out.
      length: of each, steps.
      scale: of the actions, at most 1.
    """
    rows = walks(task, episodes=episodes, length=length, scale=scale)
    kept = [step for walk in rows for step in _until_terminated(walk)]
    return _stacked(kept)


def walks(task: GymnasiumTask, *, episodes: int, length: int, scale: float) -> list[list[Steps]]:
    """Returns the steps of each episode; they go on where a trial has ended."""
    env, rng = make(task), np.random.default_rng(0)
    half = 0.5 * (env.action_space.high - env.action_space.low).astype(float)
    found: list[list[Steps]] = []
    for episode in range(episodes):
        env.reset(seed=episode)
        action, rows = np.zeros(env.model.nu), list[Steps]()
        for step in range(length):
            if step % 4 == 0:
                action = scale * rng.uniform(-1.0, 1.0, env.model.nu)
            before = state_of(task, env.data)
            observation, reward, terminated, _, _ = env.step(half * action)
            places = env.data.qpos.copy(), env.data.qvel.copy()
            rows.append(Steps(before, action, *places, observation, reward, terminated))
        found.append(rows)
    return found


def parallel(task: GymnasiumTask, *, episodes: int, length: int, scale: float) -> Steps:
    """Returns the same with leaves [step, episode, ...]."""
    rows = walks(task, episodes=episodes, length=length, scale=scale)
    return _stacked([_stacked(list(each)) for each in zip(*rows, strict=True)])


def single(tree: Any) -> Any:
    """Returns arrays in float32 where they were in float64."""
    return jax.tree.map(
        lambda leaf: leaf.astype(np.float32) if leaf.dtype == np.float64 else leaf, tree
    )


def stepping(task: GymnasiumTask) -> Any:
    """Returns our step as a function of a state and an action."""
    nowhere: Any = None  # nothing depends on the trial that is given
    return lambda state, action: task.step(state, action, nowhere)


def _until_terminated(walk: list[Steps]) -> list[Steps]:
    ended = [place for place, step in enumerate(walk) if step.terminated]
    return walk[: ended[0] + 1] if ended else walk


def _stacked(rows: list[Steps]) -> Steps:
    return Steps(*jax.tree.map(lambda *leaves: np.stack(leaves), *map(tuple, rows)))


if __name__ == "__main__":
    assert os.environ.get("JAX_ENABLE_X64")
    asked = TASKS[sys.argv[1]]()
    given = parallel(asked, episodes=4, length=100, scale=0.1)
    step = jax.jit(jax.vmap(stepping(asked)))
    state = jax.tree.map(lambda leaf: leaf[0], given.before)
    for each in given.action:
        state = step(state, each)
    print(np.abs(np.asarray(state.qpos) - given.qpos[-1]).max())
