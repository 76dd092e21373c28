"""Fitness over the generations: Figures 4a, 4b and 7 of Solomon, Locascio & Hartmann (2013)."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mjxwalk.analysis import curves, figures
from mjxwalk.analysis.curves import Curve, PhaseCurves
from mjxwalk.envs.anatomy import is_spatial
from mjxwalk.report import drawing, quartiles
from mjxwalk.report.parts import Picture, Section, count, frame, number
from mjxwalk.report.sources import Phase

# Of a study's phases, that which another one is to be compared with in Figure 4b.
COUNTERPARTS = {"rsil": "fil"}


def section(variants: Mapping[str, Sequence[Phase]]) -> Section:
    """Returns the figures; variants are those of `sources.by_variant`."""
    compared = [name for name in variants if COUNTERPARTS.get(name) in variants]
    chain = {name: phases for name, phases in variants.items() if name not in compared}
    parts = [over_phases(chain)]
    parts += [_compared(name, variants) for name in compared]
    spread = quartiles.picture(variants)
    if spread is not None:
        parts.append(spread)
    text = (
        "Fitness is the distance walked before a fall or the end of the effort that a trial may "
        "cost, on new ground in each generation; so it goes up and down by the luck of the ground."
    )
    return Section(
        anchor="fitness",
        title="Fitness over the generations",
        texts=(text,),
        parts=tuple(parts),
    )


def prunes(phase: Phase) -> bool:
    """Returns whether links are removed in a phase."""
    return getattr(phase.experiment, "pruning", None) is not None


def over_phases(chain: Mapping[str, Sequence[Phase]], *, figure: str = "") -> Picture:
    """Returns the fitness of phases one after the other.

    Args:
      chain: the runs of each phase, in their order.
      figure: its number in the paper; "" for that of Solomon, Locascio & Hartmann.
    """
    last = list(chain.values())[-1][0]
    drawn: list[PhaseCurves] = []
    factors: list[str] = []
    data: list[dict[str, Any]] = []
    for name, phases in chain.items():
        factor = _factor(phases[0], last)
        if factor != 1.0:
            factors.append(
                f"Fitness of {name} is times {factor:.2g}, since its trials may cost "
                f"{1 / factor:.3g} times as much."
            )
        added = _curves(name, phases, factor)
        data += _numbers(added, factor)
        drawn += added
    alt = "; ".join(_told(phase) for phase in drawn if len(phase))
    alt = f"Two curves over the generations. {alt}."
    num = max(map(len, chain.values()))
    figure = figure or ("7" if is_spatial(last.experiment.env) else "4a")
    told = [f"Figure {figure}. Fitness of the fittest and mean fitness, {_averaged(num)}."]
    return Picture(
        name=f"figure-{figure}",
        caption=" ".join([*told, *factors, *_ends(chain)]),
        svg=drawing.inline(figures.fitness_over_phases(drawn), name=f"figure-{figure}", alt=alt),
        data=frame(data),
    )


def _compared(name: str, variants: Mapping[str, Sequence[Phase]]) -> Picture:
    names = (name, COUNTERPARTS[name])
    drawn = [curve for each in names for curve in _curves(each, variants[each], 1.0)]
    alt = f"Four curves over the generations. {'; '.join(_told(phase) for phase in drawn)}."
    return Picture(
        name="figure-4b",
        caption=(
            f"Figure 4b. Fitness of the fittest and mean fitness of {names[0]} (thick) beside "
            f"{names[1]} (thin), averages over {count(len(variants[name]), 'run')} and "
            f"{count(len(variants[names[1]]), 'run')}."
        ),
        svg=drawing.inline(figures.fitness_of_groups(drawn), name="figure-4b", alt=alt),
        data=frame(_numbers(drawn, 1.0)),
    )


def _curves(name: str, phases: Sequence[Phase], factor: float) -> list[PhaseCurves]:
    """Returns a phase's curves; of one that prunes, while links go and after."""
    metrics = [phase.run.metrics for phase in phases]
    if not prunes(phases[0]):
        return [curves.average_phase(name, metrics, scale=factor)]
    pairs = [_split(phase) for phase in phases]
    return [
        # Pruning lasts a different time in each run.
        curves.average_phase(
            f"{name}: pruning", [first for first, _ in pairs], scale=factor, stretch=True
        ),
        curves.average_phase(
            "after", [then for _, then in pairs if len(then["generation"])], scale=factor
        ),
    ]


def _split(phase: Phase) -> tuple[dict[str, Any], dict[str, Any]]:
    settled = curves.settled_generations(phase.run.strategy_state)
    return curves.split_pruning(phase.run.metrics, settled)


def _factor(phase: Phase, last: Phase) -> float:
    """Returns what makes the fitness of a phase comparable with that of the last one."""
    budgets = [float(getattr(p.experiment.env, "torque_budget", 1.0)) for p in (phase, last)]
    return budgets[1] / budgets[0]


def _ends(chain: Mapping[str, Sequence[Phase]]) -> list[str]:
    """Returns of which phases the runs have different lengths without being stretched."""
    told: list[str] = []
    for name, phases in chain.items():
        sizes = [len(phase.run.metrics["generation"]) for phase in phases]
        if min(sizes) < max(sizes) and not prunes(phases[0]):
            told.append(
                f"Runs of {name} ended after {min(sizes)} to {max(sizes)} generations; the average "
                "is of those that were still going on, and jumps where one ends."
            )
    return told


def _averaged(num_runs: int) -> str:
    if num_runs == 1:
        return "of one run"
    return f"averages over {count(num_runs, 'run')} with their standard deviations as bands"


def _told(phase: PhaseCurves) -> str:
    """Returns what a phase's curves show, in words."""
    text = [f"{phase.name}, {count(len(phase), 'generation')}"]
    for name, curve in (("the fittest", phase.best), ("the mean", phase.mean)):
        known = curve.mean[np.isfinite(curve.mean)]
        if known.size:
            text.append(f"{name} from {number(known[0], 1)} to {number(known[-1], 1)} m")
    return ", ".join(text)


def _numbers(drawn: Sequence[PhaseCurves], factor: float) -> list[dict[str, Any]]:
    """Returns a row for each generation; in it fitness has been multiplied by the factor."""
    return [
        {
            "phase": phase.name,
            "generation": place + 1,
            "runs": phase.num_runs,
            "factor": factor,
            **_of(phase.best, "fittest", place),
            **_of(phase.mean, "mean", place),
        }
        for phase in drawn
        for place in range(len(phase))
    ]


def _of(curve: Curve, name: str, place: int) -> dict[str, float]:
    return {f"{name}_m": curve.mean[place], f"{name}_sd_m": curve.sd[place]}
