"""The networks that are left of policies that are pruned, rewired or sparse from the start."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mjxwalk.analysis import networks as analysed
from mjxwalk.analysis.networks import Links
from mjxwalk.controllers import Policy
from mjxwalk.report import drawing
from mjxwalk.report.parts import (
    NOTHING,
    Column,
    Picture,
    Row,
    RowGroup,
    Section,
    Table,
    cells,
    count,
    frame,
    number,
    percent,
)
from mjxwalk.report.sources import Phase


def section(variants: Mapping[str, Sequence[Phase]]) -> Section | None:
    """Returns the networks of runs whose policies have lost links; None where there are none."""
    parts: list[Table | Picture] = []
    for name, phases in variants.items():
        thin = [phase for phase in phases if is_thin(phase)]
        if thin:
            parts += [_counted(name, thin), _picture(name, max(thin, key=_best_fitness))]
    if not parts:
        return None
    text = (
        "A link is all by which one unit reads another. Those that are gone have weights of "
        "exactly 0. Where a body has sides both share one network, which is drawn for the left."
    )
    return Section(
        anchor="networks", title="The network that is left", texts=(text,), parts=tuple(parts)
    )


def is_thin(phase: Phase) -> bool:
    """Returns whether a phase's walkers have a policy that does not have all of its links."""
    experiment = phase.experiment
    policy: Any = getattr(experiment, "controller", None)
    if not isinstance(policy, Policy):
        return False
    loses = experiment.pruning is not None or getattr(experiment, "rewiring", None) is not None
    return (loses or getattr(policy, "density", 1.0) < 1.0) and bool(_links(phase))


def _links(phase: Phase) -> list[Links]:
    return analysed.links_of(phase.experiment.controller, phase.walker.genotype)


def _best_fitness(phase: Phase) -> float:
    return float(np.nanmax(phase.run.metrics["best_fitness"]))


def _counted(name: str, phases: Sequence[Phase]) -> Table:
    """Returns how many links are left between each two layers, over all runs."""
    found = [_links(phase) for phase in phases]
    rows: list[Row] = []
    data: list[dict[str, Any]] = []
    for of_runs in zip(*found, strict=True):
        first = of_runs[0]
        left = [int(each.left.sum()) for each in of_runs]
        amounts = [
            float(np.sqrt(np.mean(each.weight[each.left] ** 2))) if each.left.any() else None
            for each in of_runs
        ]
        known = [amount for amount in amounts if amount is not None]
        rows.append(
            Row(
                f"{first.source.name} to {first.target.name}",
                cells(
                    f"{first.weight.size:,}",
                    _ranged(left),
                    percent(float(np.mean(left)) / first.weight.size),
                    number(float(np.mean(known)) if known else None, 3),
                    f"{_silent(first):,}" if len(phases) == 1 else NOTHING,
                ),
            )
        )
        data += [
            {
                "folder": phase.label,
                "seed": phase.seed,
                "from": first.source.name,
                "to": first.target.name,
                "weights": first.leaf,
                "links": first.weight.size,
                "left": num,
                "rms_weight": amount,
                "units_unread": _silent(each),
            }
            for phase, each, num, amount in zip(phases, of_runs, left, amounts, strict=True)
        ]
    several = len(phases) > 1
    networks = count(len(phases), "network") if several else "the network"
    return Table(
        name=f"network-{name}",
        caption=f"Links that are left in {networks} of {name}",
        head="from, to",
        columns=(
            Column("possible links"),
            Column("left, mean (lowest to highest)" if several else "left"),
            Column("share left"),
            Column("root mean square weight"),
            Column("units that are not read"),
        ),
        groups=(RowGroup("", tuple(rows)),),
        data=frame(data),
        note="The other side's neurons are the same units, seen from across."
        if any("other side" in row.head for row in rows)
        else "",
    )


def _silent(links: Links) -> int:
    """Returns the number of units that no unit of the other layer reads."""
    return int((~links.left.any(axis=0)).sum())


def _picture(name: str, phase: Phase) -> Picture:
    """Returns a drawing of a run's network, and its links as plain numbers."""
    links = _links(phase)
    used = {layer.name for each in links for layer in (each.source, each.target)}
    layers = [layer for layer in phase.experiment.controller.wiring().layers if layer.name in used]
    figure = analysed.drawn(layers, links)
    total = sum(int(each.left.sum()) for each in links)
    least = analysed.weakest_drawn(links)
    shown = sum(int((np.abs(each.weight[each.left]) >= least).sum()) for each in links)
    which = "" if shown == total else f" The strongest {shown:,} of {total:,} links are drawn."
    return Picture(
        name=f"network-{name}-links",
        caption=(
            f"The network of {phase.label}. Links are as wide as their weights are large; blue "
            f"ones are positive, orange ones negative.{which}"
        ),
        svg=drawing.inline(
            figure,
            name=f"network-{name}-links",
            alt=f"{count(len(layers), 'layer')} of units as columns, and {shown:,} links.",
        ),
        data=frame(
            [
                {
                    "from_layer": each.source.name,
                    "from": each.source.units[source],
                    "to_layer": each.target.name,
                    "to": each.target.units[target],
                    "weight": float(each.weight[target, source]),
                }
                for each in links
                for target, source in np.argwhere(each.left).tolist()
            ]
        ),
    )


def _ranged(values: Sequence[int]) -> str:
    mean = number(float(np.mean(values)), 0)
    return mean if len(values) == 1 else f"{mean} ({min(values):,} to {max(values):,})"
