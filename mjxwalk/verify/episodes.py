"""Episodes of Gymnasium's tasks, by one of our engines and in Gymnasium's own environment.

Nothing of Gymnasium's environment is changed: file, solver, integrator, rewards, ends and noise at
the start are its own, and C MuJoCo steps it in float64. Shared with the engine is the controller,
which JAX computes as it evolved.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Bool, Float, Int

from mjxwalk import engines, installing
from mjxwalk.engines.pinning import pinned
from mjxwalk.envs import TRIAL_AXES, Trial, Trials
from mjxwalk.envs.gymnasium import GymnasiumTask
from mjxwalk.rollout import Controller, rollout

MOST_AT_ONCE = 128  # environments of Gymnasium; ours: each holds MuJoCo's memory


class Episodes(NamedTuple):
    """What policies did in an episode each; numpy arrays [episode].

    Attributes:
      total: sum of the rewards, which reinforcement learning calls the return.
      steps: of control.
      terminated: whether the task ended it, and not its limit of steps.
    """

    total: Float[np.ndarray, " episode"]
    steps: Int[np.ndarray, " episode"]
    terminated: Bool[np.ndarray, " episode"]


@dataclasses.dataclass(frozen=True)
class _Player:
    """A task and what acts in it: the settings of the function that engines compile."""

    task: GymnasiumTask
    controller: Controller

    def play(self, genotype: Any, given: Trial) -> tuple[Any, Any, Any]:
        """Returns what `Episodes` hold of one episode."""
        outcome = rollout(self.task, self.controller, genotype, given)
        return outcome.fitness, outcome.steps, outcome.fell


@pinned()
def in_engine(
    task: GymnasiumTask, controller: Controller, genotypes: Any, trials: Trials, engine: str
) -> Episodes:
    """Returns the episodes of genotypes by an engine, each in a trial of its own.

    Args:
      task: with its settings.
      controller: what the genotypes become in it.
      genotypes: leaves [episode, ...].
      trials: as many, from `task.sample_trials`.
      engine: as `mjxwalk.engines.choose` knows it.

    Raises:
      ValueError: there is no such engine.
    """
    player = _Player(task, controller)
    mapped = engines.choose(engine).engine.vmap(player.play, (0, TRIAL_AXES), results=(0, 1, 2))
    given = jax.tree.map(np.asarray, trials.given(np.arange(trials.num, dtype=np.int32)))
    total, steps, fell = mapped(jax.tree.map(np.asarray, genotypes), given)
    return Episodes(np.asarray(total, np.float64), np.asarray(steps), np.asarray(fell))


def in_gymnasium(
    task: GymnasiumTask, controller: Controller, genotypes: Any, seeds: Sequence[int]
) -> Episodes:
    """Returns the episodes of genotypes in Gymnasium's own environment.

    Args:
      task: that Gymnasium makes by its name.
      controller: what the genotypes become in it.
      genotypes: leaves [episode, ...].
      seeds: of each episode's start.

    Raises:
      RunError: Gymnasium or what it draws with is not installed.
    """
    check_installed(task)
    parts = [
        _several(
            task,
            controller,
            jax.tree.map(lambda leaf, at=first: leaf[at : at + MOST_AT_ONCE], genotypes),
            seeds[first : first + MOST_AT_ONCE],
        )
        for first in range(0, len(seeds), MOST_AT_ONCE)
    ]
    return Episodes(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def check_installed(task: GymnasiumTask) -> None:
    """Raises RunError unless Gymnasium can make a task."""
    installing.load("gymnasium.envs.mujoco.mujoco_env", "gym", f"playing {task.ID}")


def _several(
    task: GymnasiumTask, controller: Controller, genotypes: Any, seeds: Sequence[int]
) -> Episodes:
    import gymnasium

    envs: list[Any] = [gymnasium.make(task.ID) for _ in seeds]
    space = envs[0].action_space
    middle, half = 0.5 * (space.high + space.low), 0.5 * (space.high - space.low)
    seen = np.stack(
        [env.reset(seed=int(seed))[0] for env, seed in zip(envs, seeds, strict=True)]
    ).astype(np.float32)
    act = jax.jit(jax.vmap(controller.act))
    memory = jax.jit(jax.vmap(controller.init))(genotypes)
    num = len(envs)
    total, steps = np.zeros(num), np.zeros(num, np.int64)
    terminated, done = np.zeros((2, num), bool)
    while not done.all():
        # All are shown to the controller, those at rest too: another number compiles anew.
        memory, asked = act(genotypes, memory, seen)
        actions = (middle + half * np.asarray(asked)).astype(np.float32)
        for place in np.flatnonzero(~done):
            after = envs[place].step(actions[place])
            seen[place], reward, terminated[place], truncated, _ = after
            total[place] += reward
            steps[place] += 1
            done[place] = terminated[place] or truncated
    for env in envs:
        env.close()
    return Episodes(total, steps, terminated)
