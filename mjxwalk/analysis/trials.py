"""Records trials of one walker on new terrains, for analysis."""

from typing import Any

import jax
import numpy as np

from mjxwalk import replay
from mjxwalk.evaluation import make_evaluator
from mjxwalk.replay import Recording
from mjxwalk.rollout import Outcome

TRIALS = 100  # Solomon et al. (2013), section 3.4, of each winner
# Folded into the seed's key, it leads away from the keys of runs and tournaments.
ANALYSIS = 0x67616974


def record_trials(
    experiment: Any,
    genotype: Any,
    *,
    trials: int = TRIALS,
    seed: int = 0,
    duration: float | None = None,
    frames_per_second: float = 100.0,
    engine: str = "auto",
) -> Recording:
    """Returns trials of a walker, each on a terrain of its own, as hard as its last generation's.

    Args:
      experiment: that the walker evolved in.
      genotype: of the one walker.
      trials: number of them.
      seed: of the terrains.
      duration: after which recording ends, s; None for the end of the trials.
      frames_per_second: as for `mjxwalk.replay.record`.
      engine: as `mjxwalk.engines.choose` knows it.

    Raises:
      ValueError: there is no such engine, or a number is wrong.
    """
    if trials < 1:
        raise ValueError(f"trials must be at least 1, got {trials}")
    experiment = experiment.as_tested()
    longest = experiment.env.max_time
    key = jax.random.fold_in(jax.random.key(seed), ANALYSIS)
    given = experiment.sample_trials(key, trials).given(np.arange(trials, dtype=np.int32))
    return replay.record(
        experiment.env,
        experiment.controller,
        jax.tree.map(lambda leaf: np.repeat(np.asarray(leaf)[None], trials, axis=0), genotype),
        given,
        duration=longest if duration is None else min(duration, longest),
        frames_per_second=frames_per_second,
        engine=engine,
    )


def try_alone(experiment: Any, genotype: Any, *, terrains: int, seed: int) -> Outcome:
    """Returns one walker's outcomes as numpy arrays [1, terrain], by the fastest engine.

    Args:
      experiment: that it is tried in, as it is.
      genotype: of the walker.
      terrains: number of them.
      seed: of the terrains.
    """
    alone = jax.tree.map(lambda leaf: np.asarray(leaf)[None], genotype)
    given = experiment.sample_trials(jax.random.key(seed), terrains)
    return make_evaluator(experiment, "auto").evaluate(alone, given)
