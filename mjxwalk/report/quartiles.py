"""Fitness over the generations as median and quartiles over seeds, which a lucky run cannot bend.

Ours, beside the paper's averages.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure

from mjxwalk.analysis import figures
from mjxwalk.report import drawing
from mjxwalk.report.parts import Picture, count, frame, number
from mjxwalk.report.sources import Phase

NAME = "fitness-quartiles"
SHARES = (0.25, 0.5, 0.75)
WIDTH, HEIGHT = 9.0, 2.9  # inches; of the figure, and of a phase's panel
COLUMNS = 3


def picture(variants: Mapping[str, Sequence[Phase]], *, unit: str = "m") -> Picture | None:
    """Returns the figure of all phases with several runs; None where there is none.

    Args:
      variants: runs by phase.
      unit: of the fitness; "" for none.
    """
    end = f" {unit}" if unit else ""
    found = {name: quartiles(_series(phases)) for name, phases in variants.items() if phases[1:]}
    if not found:
        return None
    told = [
        f"{name}, {count(len(variants[name]), 'run')}: in the last generation of all "
        f"{number(each[1, -1], 1)}{end}, quartiles {number(each[0, -1], 1)} and "
        f"{number(each[2, -1], 1)}{end}"
        for name, each in found.items()
    ]
    return Picture(
        name=NAME,
        caption=(
            "Fitness of the fittest: median over the seeds, and between their quartiles. A run "
            "that has ended counts on with its last fitness."
        ),
        svg=drawing.inline(
            _drawn(found, unit), name=NAME, alt=f"A line in a band. {'; '.join(told)}."
        ),
        data=frame([row for name, each in found.items() for row in _rows(name, each, unit)]),
    )


def quartiles(series: Sequence[Float[np.ndarray, " _"]]) -> Float[np.ndarray, "3 generation"]:
    """Returns lower quartile, median and upper quartile of each generation.

    Args:
      series: one a run, of any length; the last value stands for what a run would have had later.
    """
    longest = max(len(each) for each in series)
    table = np.array([np.pad(each, (0, longest - len(each)), "edge") for each in series])
    known = np.isfinite(table).any(axis=0)
    found = np.full((len(SHARES), longest), np.nan)
    found[:, known] = np.nanquantile(table[:, known], SHARES, axis=0)
    return found


def _series(phases: Sequence[Phase]) -> list[Float[np.ndarray, " _"]]:
    return [np.asarray(phase.run.metrics["best_fitness"], np.float64) for phase in phases]


def _drawn(found: Mapping[str, Float[np.ndarray, "3 _"]], unit: str) -> Figure:
    columns = min(COLUMNS, len(found))
    rows = -(-len(found) // columns)
    figure = Figure(figsize=(WIDTH, HEIGHT * rows), layout="constrained")
    axes: Any = figure.subplots(rows, columns, squeeze=False).ravel()
    for axis, (name, (low, middle, high)) in zip(axes, found.items(), strict=False):
        generations = 1 + np.arange(len(middle))
        axis.fill_between(generations, low, high, color=figures.BEST, alpha=0.2, linewidth=0)
        axis.plot(generations, middle, color=figures.BEST, linewidth=1.4)
        axis.set(xlabel="generation", ylabel=figures.fitness_label(unit))
        figures.start_at_zero(axis, low)
        axis.set_title(name, fontsize=10)
    for axis in axes[len(found) :]:
        axis.axis("off")
    return figure


def _rows(name: str, each: Float[np.ndarray, "3 _"], unit: str) -> list[dict[str, Any]]:
    end = f"_{unit}" if unit else ""
    return [
        {
            "phase": name,
            "generation": place + 1,
            f"lower_quartile{end}": low,
            f"median{end}": middle,
            f"upper_quartile{end}": high,
        }
        for place, (low, middle, high) in enumerate(each.T)
    ]
