"""Whether a policy earns in Gymnasium's own environment what an engine says."""

from collections.abc import Callable
from typing import Any

import jax
import msgspec
import numpy as np

from mjxwalk.envs.gymnasium import TASKS, GymnasiumTask, files
from mjxwalk.verify import episodes
from mjxwalk.verify.episodes import Episodes
from mjxwalk.walker import Walker

LEAST_P = 0.01  # ours: of a hundred pairs of samples of one distribution one is called different
GYMNASIUM = "Gymnasium"
# Folded into the seed's key, it leads away from the keys of runs, tournaments and analyses.
RETURNS = 0x72657475


class Returns(msgspec.Struct, frozen=True, kw_only=True):
    """The returns of a policy's episodes by one of the two.

    Attributes:
      name: of the engine, or "Gymnasium".
      returns: of each episode.
      steps: of control, of each episode.
      terminated: whether the task ended each, and not its limit of steps.
      mean: of the returns.
      deviation: standard deviation of the returns.
      lower: quartile.
      median: of the returns.
      upper: quartile.
      terminated_share: of the episodes.
      steps_mean: of all episodes.
    """

    name: str
    returns: tuple[float, ...]
    steps: tuple[int, ...]
    terminated: tuple[bool, ...]
    mean: float
    deviation: float
    lower: float
    median: float
    upper: float
    terminated_share: float
    steps_mean: float


class Played(msgspec.Struct, frozen=True, kw_only=True):
    """A walker's episodes by an engine and in Gymnasium's own environment, from other starts.

    Attributes:
      walker: its source.
      generation: in which it was the fittest.
      task: as Gymnasium makes it.
      seed: of the starts.
      engine: its side.
      reference: Gymnasium's.
      p_value: of the Kolmogorov-Smirnov test of two samples, of the returns.
      agrees: whether it is not below its limit.
    """

    walker: str
    generation: int
    task: str
    seed: int
    engine: Returns
    reference: Returns
    p_value: float
    agrees: bool


def play(
    walker: Walker, *, engine: str, trials: int, seed: int, say: Callable[[str], None]
) -> Played:
    """Returns how a walker's returns by an engine and in Gymnasium's own environment agree.

    Both are of the task with Gymnasium's own settings, whatever the walker evolved with.

    Args:
      walker: of one of Gymnasium's tasks.
      engine: as `mjxwalk.engines.choose` knows it.
      trials: episodes of each.
      seed: of their starts.
      say: is told what goes on.

    Raises:
      RunError: Gymnasium is not installed.
      ValueError: there is no such engine, or the walker has another body than Gymnasium's.
    """
    task = as_gymnasium_has_it(walker)
    controller = walker.experiment.controller.on(task)
    several = jax.tree.map(lambda leaf: np.stack([np.asarray(leaf)] * trials), walker.genotype)
    key = jax.random.fold_in(jax.random.key(seed), RETURNS)
    say(f"{walker.name}, generation {walker.generation}, {trials} episodes by engine {engine}")
    own = episodes.in_engine(task, controller, several, task.sample_trials(key, trials), engine)
    say(f"as many of gymnasium.make({task.ID!r}), in float64")
    theirs = episodes.in_gymnasium(task, controller, several, seeds(seed, trials))
    one, other = side(engine, own), side(GYMNASIUM, theirs)
    p_value = same_distribution(one.returns, other.returns)
    return Played(
        walker=walker.name,
        generation=walker.generation,
        task=task.ID,
        seed=seed,
        engine=one,
        reference=other,
        p_value=p_value,
        agrees=p_value >= LEAST_P,
    )


def as_gymnasium_has_it(walker: Walker) -> GymnasiumTask:
    """Returns a walker's task with Gymnasium's own settings.

    Raises:
      RunError: Gymnasium is not installed.
      ValueError: the walker has another body than Gymnasium's.
    """
    env = walker.experiment.env
    episodes.check_installed(env)
    if env.body != files.text(env.FILE):
        raise ValueError(
            f"{walker.name} evolved with another body than that of the installed Gymnasium's "
            f"{env.ID}, which has no environment of that body to play in"
        )
    return TASKS[env.ID]()


def seeds(seed: int, num: int) -> list[int]:
    """Returns the seeds of so many episodes in Gymnasium."""
    return np.random.SeedSequence([seed, RETURNS]).generate_state(num).tolist()


def side(name: str, played: Episodes) -> Returns:
    """Returns the figures of episodes.

    Args:
      name: of whose they are.
      played: one or more.
    """
    lower, median, upper = np.percentile(played.total, [25, 50, 75]).tolist()
    return Returns(
        name=name,
        returns=tuple(played.total.tolist()),
        steps=tuple(played.steps.tolist()),
        terminated=tuple(played.terminated.tolist()),
        mean=float(played.total.mean()),
        deviation=float(played.total.std()),
        lower=lower,
        median=median,
        upper=upper,
        terminated_share=float(played.terminated.mean()),
        steps_mean=float(played.steps.mean()),
    )


def same_distribution(one: Any, other: Any) -> float:
    """Returns how probable samples so far apart are if they are of one distribution.

    That is the p-value of the Kolmogorov-Smirnov test of two samples.
    """
    from scipy import stats  # takes a second

    result: Any = stats.ks_2samp(one, other)
    return float(result.pvalue)
