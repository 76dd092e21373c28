"""Measures a gait: speed, step length, double stance and cost, over trials and over runs.

Table 5 of Solomon, Locascio & Hartmann (2013), Adaptive Behavior 21(1), doi
10.1177/1059712312462904, section 3.4: means over trials without a fall, 100 for each winner, and
standard deviations between winners.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.analysis.footfalls import find_footfalls, observe
from mjxwalk.analysis.frame import Frame
from mjxwalk.analysis.strides import SHORTEST_PHASE, Strides, find_strides, no_strides
from mjxwalk.replay import Recording

FIGURES = (
    "speed_m_s",
    "step_length_m",
    "double_stance",
    "stride_time_s",
    "swing_time_s",
    "cost_of_transport",
)


class Spread(NamedTuple):
    """A figure of several trials, or of several runs.

    Attributes:
      mean: NaN where nothing has the figure.
      sd: between them, with one degree of freedom less; NaN of fewer than two.
      num: that have the figure.
    """

    mean: float
    sd: float
    num: int


class Gait(NamedTuple):
    """What a walker does, over its trials without a fall, or over several walkers.

    Attributes:
      trials: of all kinds.
      falls: trials that ended by a fall.
      strides: that were found in the others.
      speed_m_s: distance over duration of a trial, its start included.
      step_length_m: from one foot's touch-down to the other's, forward.
      double_stance: share of a stride in which both feet are on the ground.
      stride_time_s: from a foot's touch-down to its next.
      swing_time_s: of it, with the foot in the air.
      cost_of_transport: work over weight times distance.
    """

    trials: int
    falls: int
    strides: int
    speed_m_s: Spread
    step_length_m: Spread
    double_stance: Spread
    stride_time_s: Spread
    swing_time_s: Spread
    cost_of_transport: Spread


def measure_gait(recording: Recording, env: Any) -> Gait:
    """Returns what the recorded walkers do; meant for many trials of one walker.

    Args:
      recording: of trials from their start.
      env: that they are trials of, with its `weight`.
    """
    return summarise(measure_trials(recording, env))


def measure_trials(recording: Recording, env: Any, *, shortest: float = SHORTEST_PHASE) -> Frame:
    """Returns a row for each trial: `fell`, `strides`, duration, distance and all of `FIGURES`.

    Figures of strides are means over those of the trial, NaN of a trial without, and of bodies on
    more than two feet.

    Args:
      recording: of trials from their start.
      env: that they are trials of, with its `weight`.
      shortest: contact phase that counts, s.
    """
    import pandas as pd

    observations = observe(recording, env)
    rows: list[dict[str, Any]] = []
    for walker, footfalls in enumerate(find_footfalls(recording, observations, shortest=shortest)):
        # ours: strides are told of two feet alone; of more, which follows which is the gait's own.
        has_strides = footfalls.contact.shape[1] == 2
        strides = (
            find_strides(footfalls.time, footfalls.contact, footfalls.ankle_x)
            if has_strides
            else no_strides()
        )
        last = recording.states
        distance = float(last.qpos[-1, walker, 0] - last.qpos[0, walker, 0])
        duration = float(recording.time[-1, walker])
        work = float(last.trial.work[-1, walker])
        rows.append(
            {
                "fell": bool(last.trial.fell[-1, walker]),
                "strides": len(strides.end),
                "duration_s": duration,
                "distance_m": distance,
                "speed_m_s": distance / duration if duration > 0 else np.nan,
                **_of_strides(strides),
                "cost_of_transport": work / (env.weight * distance) if distance > 0 else np.nan,
            }
        )
    return pd.DataFrame(rows)


def summarise(trials: Frame) -> Gait:
    """Returns means and deviations over the trials without a fall.

    Args:
      trials: from `measure_trials`; several walkers' may be joined.
    """
    sound = trials[~trials["fell"]]
    return Gait(
        trials=len(trials),
        falls=int(trials["fell"].sum()),
        strides=int(sound["strides"].sum()),
        **{name: spread(sound[name].to_numpy(np.float64)) for name in FIGURES},
    )


def across(gaits: Sequence[Gait]) -> Gait:
    """Returns means and deviations between walkers, each counting once; trials are added up."""
    return Gait(
        trials=sum(gait.trials for gait in gaits),
        falls=sum(gait.falls for gait in gaits),
        strides=sum(gait.strides for gait in gaits),
        **{
            name: spread(np.array([getattr(gait, name).mean for gait in gaits], np.float64))
            for name in FIGURES
        },
    )


def spread(values: Float[np.ndarray, " value"]) -> Spread:
    """Returns mean and deviation of the values that are numbers."""
    known = values[np.isfinite(values)]
    return Spread(
        mean=float(known.mean()) if known.size else np.nan,
        sd=float(known.std(ddof=1)) if known.size > 1 else np.nan,
        num=int(known.size),
    )


def _of_strides(strides: Strides) -> dict[str, float]:
    """Returns what a trial's strides are on average; long strides count for more of the stance."""
    if not len(strides.end):
        return dict.fromkeys(
            ("step_length_m", "double_stance", "stride_time_s", "swing_time_s"), np.nan
        )
    both = strides.double_stance * strides.duration
    return {
        "step_length_m": float(strides.step_length.mean()),
        "double_stance": float(both.sum() / strides.duration.sum()),
        "stride_time_s": float(strides.duration.mean()),
        "swing_time_s": float(strides.swing_time.mean()),
    }
