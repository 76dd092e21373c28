"""What the winner of each phase does on new ground, at other time steps and from other starts."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from mjxwalk.analysis.gait import Spread
from mjxwalk.analysis.gait import spread as spread_of
from mjxwalk.analysis.intervals import wilson
from mjxwalk.report.parts import (
    Column,
    Row,
    RowGroup,
    Section,
    Table,
    cells,
    frame,
    number,
    percent,
    spread,
)
from mjxwalk.report.sources import Phase
from mjxwalk.tournament import Condition
from mjxwalk.tournament.results import AS_EVOLVED

COLUMNS = (
    Column("trials"),
    Column("distance (m)"),
    Column("falls (95 % interval)"),
    Column("falls per 100\N{NO-BREAK SPACE}m"),
    Column("cost of transport"),
    Column("speed (m/s)"),
    Column("step length (m)"),
    Column("double stance"),
)
AT_THE_END = "at the end of the run"  # of a champion that no tournament was held for


class Tried(NamedTuple):
    """Trials of one winner, or of several together.

    Attributes:
      winners: number of them.
      trials: of all.
      falls: of these.
      metres: walked in all.
      distance: mean and deviation; of one winner between its trials, else between winners.
      figures: likewise by name, between winners.
    """

    winners: int
    trials: int
    falls: int
    metres: float
    distance: Spread
    figures: Mapping[str, Spread]

    @property
    def falls_per_100_m(self) -> float:
        """NaN of walkers that did not get forward."""
        return 100 * self.falls / self.metres if self.metres > 0 else np.nan


FIGURES = {"cost_of_transport": 3, "speed_m_s": 2, "step_length_m": 3}  # and their places


def section(variants: Mapping[str, Sequence[Phase]]) -> Section:
    """Returns the winners under each of the conditions, together and one by one."""
    parts = [_together(variants)]
    if any(len(phases) > 1 for phases in variants.values()):
        parts.append(_one_by_one(variants))
    text = (
        "The fittest of the last generations compete on new ground; the winner is tried on ground "
        "that is new again. A gait that holds at one time step only is an artefact of it."
    )
    return Section(
        anchor="winners", title="The winners on new ground", texts=(text,), parts=tuple(parts)
    )


def conditions(phase: Phase) -> tuple[Condition, ...]:
    """Returns what a phase's winner does; what its champion does if no tournament was held."""
    if phase.tournament is not None and phase.tournament.conditions:
        return phase.tournament.conditions
    if phase.run.result is None:
        return ()
    champion = phase.run.result.champion
    interval = wilson(round(champion.fall_rate * champion.terrains), champion.terrains)
    return (
        Condition(
            name=AT_THE_END,
            trials=champion.terrains,
            distance_mean_m=champion.distance_m,
            distance_sd_m=float("nan"),
            fall_rate=champion.fall_rate,
            fall_rate_low=interval.low,
            fall_rate_high=interval.high,
            cost_of_transport=champion.cost_of_transport,
            speed_m_s=champion.speed_m_s,
            step_length_m=None,
            double_stance=None,
        ),
    )


def usual(phase: Phase) -> Condition | None:
    """Returns the winner's trials under the conditions that it evolved under, if there are any."""
    found = {each.name: each for each in conditions(phase)}
    return found.get(AS_EVOLVED, found.get(AT_THE_END))


def gathered(given: Sequence[Condition]) -> Tried:
    """Returns the trials of several winners together; there is one at least."""
    means = np.array([each.distance_mean_m for each in given], np.float64)
    trials = np.array([each.trials for each in given])
    distance = spread_of(means)
    if len(given) == 1:
        distance = distance._replace(sd=given[0].distance_sd_m)
    return Tried(
        winners=len(given),
        trials=int(trials.sum()),
        falls=sum(round(each.fall_rate * each.trials) for each in given),
        metres=float((means * trials).sum()),
        distance=distance,
        figures={
            name: spread_of(
                np.array([np.nan if (v := getattr(c, name)) is None else v for c in given], float)
            )
            for name in (*FIGURES, "double_stance")
        },
    )


def _together(variants: Mapping[str, Sequence[Phase]]) -> Table:
    groups: list[RowGroup] = []
    data: list[dict[str, Any]] = []
    for variant, phases in variants.items():
        named: dict[str, list[Condition]] = {}
        for condition in (each for phase in phases for each in conditions(phase)):
            named.setdefault(condition.name, []).append(condition)
        tried = {name: gathered(given) for name, given in named.items()}
        rows = [Row(name, cells(str(each.winners), *_texts(each))) for name, each in tried.items()]
        groups.append(RowGroup(variant, tuple(rows) or (_nothing(),)))
        data += [{"phase": variant, "conditions": n, **_numbers(t)} for n, t in tried.items()]
    return Table(
        name="winners",
        caption="The winner of each phase",
        head="conditions",
        columns=(Column("winners"), *COLUMNS),
        groups=tuple(groups),
        data=frame(data),
        note=(
            "± is the standard deviation between winners; of one winner, that of the distance "
            "between its trials. The interval of the falls is Wilson's over all trials, and tells "
            "how well these winners are known. Speed, step length and double stance are of trials "
            "without a fall."
        ),
    )


def _one_by_one(variants: Mapping[str, Sequence[Phase]]) -> Table:
    groups: list[RowGroup] = []
    data: list[dict[str, Any]] = []
    for variant, phases in variants.items():
        rows: list[Row] = []
        for phase in phases:
            data += [_named(phase, each) for each in conditions(phase)]
            condition = usual(phase)
            if condition is not None:
                generation = str(phase.walker.generation)
                rows.append(Row(phase.label, cells(generation, *_texts(gathered([condition])))))
        groups.append(RowGroup(variant, tuple(rows) or (_nothing(),)))
    return Table(
        name="winners-by-run",
        caption="The winner of each run, as it evolved",
        head="folder",
        columns=(Column("generation"), *COLUMNS),
        groups=tuple(groups),
        data=frame(data),
        note="The file has the other conditions too.",
    )


def _named(phase: Phase, condition: Condition) -> dict[str, Any]:
    return {
        "phase": phase.name,
        "folder": phase.label,
        "seed": phase.seed,
        "generation": phase.walker.generation,
        "conditions": condition.name,
        **_numbers(gathered([condition])),
    }


def _nothing() -> Row:
    return Row("no tournament yet", cells(*[""] * (1 + len(COLUMNS))))


def _texts(tried: Tried) -> list[str]:
    low, high = wilson(tried.falls, tried.trials)
    figures = tried.figures
    stance = figures["double_stance"]
    return [
        f"{tried.trials:,}",
        spread(tried.distance.mean, tried.distance.sd, 2),
        f"{percent(tried.falls / tried.trials)} ({100 * low:.1f} to {100 * high:.1f})",
        number(tried.falls_per_100_m, 2),
        *(spread(figures[name].mean, figures[name].sd, places) for name, places in FIGURES.items()),
        percent(stance.mean),
    ]


def _numbers(tried: Tried) -> dict[str, Any]:
    low, high = wilson(tried.falls, tried.trials)
    numbers: dict[str, Any] = {
        "winners": tried.winners,
        "trials": tried.trials,
        "distance_m": tried.distance.mean,
        "distance_sd_m": tried.distance.sd,
        "fall_rate": tried.falls / tried.trials,
        "fall_rate_low": low,
        "fall_rate_high": high,
        "falls_per_100_m": tried.falls_per_100_m,
    }
    for name, figure in tried.figures.items():
        numbers |= {name: figure.mean, f"{name}_sd": figure.sd}
    return numbers
