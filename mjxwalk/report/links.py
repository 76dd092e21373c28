"""Which links pruning leaves: Table 3 of Solomon, Locascio & Hartmann (2013), and how it went."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mjxwalk.analysis import links as analysed
from mjxwalk.analysis import paper, tables
from mjxwalk.controllers.linear_reactive import local_links
from mjxwalk.report.fitness import prunes
from mjxwalk.report.parts import (
    LOST,
    NOTHING,
    Cell,
    Column,
    Row,
    RowGroup,
    Section,
    Table,
    count,
    frame,
    number,
    percent,
    quoted,
)
from mjxwalk.report.sources import Phase
from mjxwalk.strategies.links import SURVIVAL_THRESHOLD

OURS_AND_PAPERS = ("ours", "paper")


def section(variants: Mapping[str, Sequence[Phase]]) -> Section:
    """Returns how many links are left in the winners of the phases that prune."""
    parts: list[Table] = []
    for name, phases in variants.items():
        pruned = [phase for phase in phases if is_pruned(phase)]
        if pruned:
            parts += _tables(name, pruned)
    text = (
        "Every network always sees its own angle, its rate and a bias; the other links may go. "
        f"The reduced set has those that are left in {percent(SURVIVAL_THRESHOLD, 0)} of the runs."
        if parts
        else "Table 3 counts the links that pruning leaves; none of these runs prunes."
    )
    return Section(
        anchor="links", title="The links that are left", texts=(text,), parts=tuple(parts)
    )


def is_pruned(phase: Phase) -> bool:
    """Returns whether a phase removes links that Table 3 counts."""
    return prunes(phase) and hasattr(phase.walker.genotype, "walking")


def _tables(name: str, phases: Sequence[Phase]) -> list[Table]:
    present = analysed.presence([phase.walker.genotype for phase in phases])
    survivors = analysed.survivors(present)
    return [
        _summary(name, present),
        _survival(name, present, survivors),
        _course(name, phases, present),
    ]


def _summary(name: str, present: Any) -> Table:
    data = tables.table_3_summary(present)
    rows = [
        Row(
            str(network),
            (
                Cell(percent(row["kept"], 0)),
                Cell(percent(row["paper_kept"], 0), is_quoted=True),
                Cell(number(row["reduced_links"], 0)),
                Cell(number(row["paper_reduced_links"], 0), is_quoted=True),
            ),
        )
        for network, row in data.iterrows()
    ]
    several = len(present) > 1
    return Table(
        name=f"table-3-{name}-networks",
        caption=f"Table 3, summary. Non-local links that each network keeps in {name}",
        head="network",
        columns=tuple(
            Column(title, group)
            for group in ("kept", "links of the reduced set")
            for title in OURS_AND_PAPERS
        ),
        groups=(RowGroup("", tuple(rows)),),
        data=data.reset_index(),
        note=(
            f"Ours is the average over {count(len(present), 'winner')}, the paper's over "
            f"{paper.RUNS}."
            + ("" if several else " The reduced set of one run is simply all that it has left.")
        ),
    )


def _survival(name: str, present: Any, survivors: Any) -> Table:
    counts = analysed.survival_table(present)
    reduced, local = analysed.reduced(present), local_links()
    several = len(present) > 1

    def cell(network: int, place: int) -> Cell:
        num = int(survivors[network, place])
        if local[network, place]:
            return Cell("always", share=1.0)
        share = num / len(present)
        if not several:
            return Cell("left" if num else NOTHING, share=share)
        return Cell(str(num), share=share, is_marked=bool(reduced[network, place]))

    rows = [
        Row(str(sense), tuple(cell(network, place) for network in range(len(survivors))))
        for place, sense in enumerate(counts.index)
    ]
    caption = f"In how many of {len(present)} winners of {name} a link is left"
    return Table(
        name=f"table-3-{name}",
        caption=f"Table 3. {caption if several else f'Which links the winner of {name} has left'}",
        head="input",
        columns=tuple(Column(str(network)) for network in counts.columns),
        groups=(RowGroup("", tuple(rows)),),
        data=counts.rename_axis("input").reset_index(),
        note=("Bold: in the reduced set. " if several else "")
        + "The paper's counts are lost; its percentages are above.",
    )


def _course(name: str, phases: Sequence[Phase], present: Any) -> Table:
    states = [phase.run.strategy_state for phase in phases]
    ended = [int(state["stopped_at"]) for state in states if int(state["stopped_at"]) >= 0]
    fitness = [
        float(np.nanmedian(state["recent"]) / np.nanmedian(state["reference"])) for state in states
    ]
    num_free = int((~local_links()).sum())
    kept = (present & ~local_links()).sum(axis=(1, 2))
    papers_time = quoted(paper.PRUNING_GENERATIONS, 0)
    # Derived from its percentages.
    papers_kept = round(sum(paper.RETENTION.values()) / len(paper.RETENTION) * num_free)
    rows = (
        ("generations until removing ended", _ranged(ended, 0), papers_time.text),
        (f"non-local links left, of {num_free}", _ranged(kept.tolist(), 0), str(papers_kept)),
        ("fitness of the latest elites, of that before pruning", _ranged(fitness, 2), LOST),
    )
    return Table(
        name=f"pruning-{name}",
        caption=f"How pruning went in {name}",
        head="mean, and lowest to highest",
        columns=tuple(map(Column, OURS_AND_PAPERS)),
        groups=(
            RowGroup("", tuple(Row(h, (Cell(o), Cell(p, is_quoted=True))) for h, o, p in rows)),
        ),
        data=frame(
            [
                {
                    "folder": phase.label,
                    "seed": phase.seed,
                    "generations_until_removing_ended": int(state["stopped_at"])
                    if int(state["stopped_at"]) >= 0
                    else None,
                    "links_left": int(left),
                    "fitness_kept": share,
                }
                for phase, state, left, share in zip(phases, states, kept, fitness, strict=True)
            ]
        ),
        note=(
            f"Removing ended in {len(ended)} of {count(len(phases), 'run')}. The paper: "
            f"{paper.PRUNING_GENERATIONS.source}; its number of links left is derived from its "
            "percentages."
        ),
    )


def _ranged(values: Sequence[float | int], places: int) -> str:
    if not values:
        return NOTHING
    mean = number(float(np.mean(values)), places)
    if len(values) == 1:
        return mean
    lowest, highest = (number(float(end), places) for end in (min(values), max(values)))
    return f"{mean} ({lowest} to {highest})"
