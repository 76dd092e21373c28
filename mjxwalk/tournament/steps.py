"""The steps of a winner's trials: how long they are, and how long both feet stand.

Solomon, Locascio & Hartmann (2013), section 3.4: over 100 trials without a fall.
"""

import math
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Bool

from mjxwalk import replay
from mjxwalk.analysis.gait import measure_gait
from mjxwalk.envs import LeggedEnv
from mjxwalk.tournament.conditions import Setting

TRIALS = 100  # section 3.4
SECONDS = 15.0  # ours: of each trial; thousands of steps in all


class Steps(NamedTuple):
    """Means over the recorded trials; None where there were no strides."""

    length_m: float | None
    double_stance: float | None


def measure(
    setting: Setting, genotype: Any, fell: Bool[np.ndarray, " terrain"], engine: str
) -> Steps:
    """Returns the steps of a walker in some of the trials that it did not fall in.

    Args:
      setting: the conditions, with their trials.
      genotype: leaves [1, ...].
      fell: in which trials it did.
      engine: that runs them again.
    """
    env = setting.experiment.env
    rows = np.flatnonzero(~fell)[:TRIALS]
    if not rows.size or not isinstance(env, LeggedEnv):
        return Steps(None, None)
    recording = replay.record(
        env,
        setting.experiment.controller,
        jax.tree.map(lambda leaf: np.repeat(np.asarray(leaf), len(rows), axis=0), genotype),
        setting.trials.take(rows).given(np.arange(len(rows), dtype=np.int32)),
        duration=SECONDS,
        engine=engine,
    )
    gait = measure_gait(recording, env)
    return Steps(_known(gait.step_length_m.mean), _known(gait.double_stance.mean))


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None
