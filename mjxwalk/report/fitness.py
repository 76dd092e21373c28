"""Fitness over the generations.

Of bodies of the paper these are Figures 4a, 4b and 7 of Solomon, Locascio & Hartmann (2013).
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mjxwalk.analysis import curves, figures
from mjxwalk.analysis.curves import Curve, PhaseCurves
from mjxwalk.envs import FitnessTerms
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
    lasts = [phases[-1] for phases in variants.values()]
    spread = quartiles.picture(variants, unit=unit(lasts[-1]))
    if spread is not None:
        parts.append(spread)
    text = f"Fitness is {_meaning(lasts[-1])}, on new ground in each generation; so it goes up and "
    return Section(
        anchor="fitness",
        title="Fitness over the generations",
        texts=(f"{text}down by the luck of the ground.",),
        parts=tuple(parts),
    )


def unit(phase: Phase) -> str:
    """Returns the unit of a phase's fitness; "" where it is a sum of several terms."""
    return "m" if _terms(phase) is None else ""


def _terms(phase: Phase) -> FitnessTerms | None:
    return getattr(getattr(phase.experiment, "env", None), "terms", None)


def _meaning(phase: Phase) -> str:
    """Returns what a phase's fitness is, in words."""
    terms = _terms(phase)
    if terms is None:
        return "the distance walked before a fall or the end of the effort that a trial may cost"
    weights = ", ".join(f"{name} {weight:g}" for name, weight in terms.weights().items() if weight)
    speed = f", at a wanted speed of {terms.speed:g} m/s" if terms.speed else ""
    return f"the sum of weighted terms until the trial ends ({weights}{speed})"


def prunes(phase: Phase) -> bool:
    """Returns whether links are removed in a phase."""
    return getattr(phase.experiment, "pruning", None) is not None


def over_phases(chain: Mapping[str, Sequence[Phase]], *, figure: str = "") -> Picture:
    """Returns the fitness of phases one after the other.

    Args:
      chain: the runs of each phase, in their order.
      figure: its number in the paper; "" for that of Solomon, Locascio & Hartmann, and for none of
        other bodies.
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
        data += _numbers(added, factor, unit(last))
        drawn += added
    alt = "; ".join(_told(phase, unit(last)) for phase in drawn if len(phase))
    alt = f"Two curves over the generations. {alt}."
    num = max(map(len, chain.values()))
    if not figure and last.is_paper:
        figure = "7" if is_spatial(last.experiment.env) else "4a"
    name = f"figure-{figure}" if figure else "fitness"
    title = f"Figure {figure}. " if figure else ""
    told = [f"{title}Fitness of the fittest and mean fitness, {_averaged(num)}."]
    drawing_of = figures.fitness_over_phases(drawn, unit=unit(last))
    return Picture(
        name=name,
        caption=" ".join([*told, *factors, *_ends(chain)]),
        svg=drawing.inline(drawing_of, name=name, alt=alt),
        data=frame(data),
    )


def _compared(name: str, variants: Mapping[str, Sequence[Phase]]) -> Picture:
    names = (name, COUNTERPARTS[name])
    drawn = [curve for each in names for curve in _curves(each, variants[each], 1.0)]
    told = "; ".join(_told(phase, "m") for phase in drawn)
    alt = f"Four curves over the generations. {told}."
    return Picture(
        name="figure-4b",
        caption=(
            f"Figure 4b. Fitness of the fittest and mean fitness of {names[0]} (thick) beside "
            f"{names[1]} (thin), averages over {count(len(variants[name]), 'run')} and "
            f"{count(len(variants[names[1]]), 'run')}."
        ),
        svg=drawing.inline(figures.fitness_of_groups(drawn), name="figure-4b", alt=alt),
        data=frame(_numbers(drawn, 1.0, "m")),
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


def _told(phase: PhaseCurves, unit: str) -> str:
    """Returns what a phase's curves show, in words."""
    text = [f"{phase.name}, {count(len(phase), 'generation')}"]
    end = f" {unit}" if unit else ""
    for name, curve in (("the fittest", phase.best), ("the mean", phase.mean)):
        known = curve.mean[np.isfinite(curve.mean)]
        if known.size:
            text.append(f"{name} from {number(known[0], 1)} to {number(known[-1], 1)}{end}")
    return ", ".join(text)


def _numbers(drawn: Sequence[PhaseCurves], factor: float, unit: str) -> list[dict[str, Any]]:
    """Returns a row for each generation; in it fitness has been multiplied by the factor."""
    return [
        {
            "phase": phase.name,
            "generation": place + 1,
            "runs": phase.num_runs,
            "factor": factor,
            **_of(phase.best, "fittest", place, unit),
            **_of(phase.mean, "mean", place, unit),
        }
        for phase in drawn
        for place in range(len(phase))
    ]


def _of(curve: Curve, name: str, place: int, unit: str) -> dict[str, float]:
    end = f"_{unit}" if unit else ""
    return {f"{name}{end}": curve.mean[place], f"{name}_sd{end}": curve.sd[place]}
