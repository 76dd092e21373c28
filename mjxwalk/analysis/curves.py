"""Averages of fitness over runs: the curves of Figure 4.

Solomon, Locascio & Hartmann (2013), Adaptive Behavior 21(1), doi 10.1177/1059712312462904, section
3.1. Runs of one length are averaged generation by generation; pruning lasts a different time in
each run, and is stretched to their mean length before.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float


class Curve(NamedTuple):
    """A figure of each generation over runs.

    Attributes:
      mean: over the runs that have it, NaN where none has.
      sd: between them; NaN of fewer than two.
    """

    mean: Float[np.ndarray, " generation"]
    sd: Float[np.ndarray, " generation"]


class PhaseCurves(NamedTuple):
    """One phase of a study, averaged over runs.

    Attributes:
      name: of the phase, as text to show.
      best: fitness of the fittest.
      mean: fitness of the whole population.
      num_runs: that are averaged.
    """

    name: str
    best: Curve
    mean: Curve
    num_runs: int

    def __len__(self) -> int:
        return len(self.best.mean)


def average_phase(
    name: str,
    metrics: Sequence[Mapping[str, Any]],
    *,
    scale: float = 1.0,
    stretch: bool = False,
) -> PhaseCurves:
    """Returns a phase's curves.

    Args:
      name: of the phase.
      metrics: of each run, columns as in `mjxwalk.runs.Run.metrics`.
      scale: factor on fitness; the paper takes a third for LPD, whose budget is three times as big.
      stretch: whether runs of different lengths are stretched to their mean length; if not, a run
        that was cut short counts for the generations that it has.
    """
    curves: list[Curve] = []
    for column in ("best_fitness", "mean_fitness"):
        series = [scale * np.asarray(each[column], np.float64) for each in metrics]
        curves.append(average(stretched(series) if stretch else series))
    return PhaseCurves(name, curves[0], curves[1], len(metrics))


def average(series: Sequence[Float[np.ndarray, " _"]]) -> Curve:
    """Returns the average of series that may end at different times or lack values (NaN)."""
    longest = max((len(each) for each in series), default=0)
    table = np.full((len(series), longest), np.nan)
    for row, each in zip(table, series, strict=True):
        row[: len(each)] = each
    known = np.isfinite(table)
    num = known.sum(axis=0)
    mean = np.where(known, table, 0.0).sum(axis=0) / np.where(num > 0, num, np.nan)
    squares = np.where(known, (table - mean) ** 2, 0.0).sum(axis=0)
    return Curve(mean, np.sqrt(squares / np.where(num > 1, num - 1, np.nan)))


def stretched(
    series: Sequence[Float[np.ndarray, " _"]], length: int | None = None
) -> list[Float[np.ndarray, " generation"]]:
    """Returns series stretched or squeezed to one length, by linear interpolation.

    Args:
      series: one a run; empty ones are left out.
      length: None for the mean of theirs.
    """
    kept = [each for each in series if len(each)]
    if not kept:
        return []
    size = round(np.mean([len(each) for each in kept])) if length is None else length
    places = np.linspace(0.0, 1.0, size)
    return [np.interp(places, np.linspace(0.0, 1.0, len(each)), each) for each in kept]


def settled_generations(strategy_state: Mapping[str, Any]) -> int:
    """Returns how many generations a pruned run has gone on since pruning ended, 0 before that.

    Args:
      strategy_state: as `mjxwalk.runs.Run.strategy_state` has it.
    """
    stopped_at = int(strategy_state["stopped_at"])
    return int(strategy_state["age"]) - stopped_at if stopped_at >= 0 else 0


def split_pruning(
    metrics: Mapping[str, Any], settled: int
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns the metrics of a pruned run while links went, and after that.

    Args:
      metrics: of the run, columns as in `mjxwalk.runs.Run.metrics`.
      settled: generations since pruning ended, from `settled_generations`.
    """
    until = max(len(metrics["generation"]) - settled, 0)
    parts = (slice(None, until), slice(until, None))
    first, second = ({name: column[part] for name, column in metrics.items()} for part in parts)
    return first, second
