"""What walking costs and how often walkers fall.

Of bodies of the paper this is Table 4 of Solomon, Locascio & Hartmann (2013), beside its numbers.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from mjxwalk.analysis import paper, tables
from mjxwalk.analysis.tables import Benchmark
from mjxwalk.envs.anatomy import is_spatial
from mjxwalk.report import winners
from mjxwalk.report.parts import (
    Cell,
    Column,
    Row,
    RowGroup,
    Section,
    Table,
    cells,
    percent,
    quoted,
    spread,
)
from mjxwalk.report.sources import Phase, is_paper


def section(variants: Mapping[str, Sequence[Phase]]) -> Section:
    """Returns falls and cost of transport of the winners as they evolved."""
    given = {name: _benchmarks(phases) for name, phases in variants.items()}
    given = {name: found for name, found in given.items() if found}
    text = (
        "The cost of transport is the work of the joints, braking included, over weight times "
        "distance."
        if given
        else "No winner has been tried yet."
    )
    return Section(
        anchor="benchmarks",
        title="What walking costs, and how often they fall",
        texts=(text,),
        parts=(_of_paper(variants, given) if is_paper(variants) else _plain(given),)
        if given
        else (),
    )


def _benchmarks(phases: Sequence[Phase]) -> list[Benchmark]:
    usual = [winners.usual(phase) for phase in phases]
    return [
        Benchmark(
            trials=each.trials,
            falls=round(each.fall_rate * each.trials),
            cost_of_transport=each.cost_of_transport,
        )
        for each in usual
        if each is not None
    ]


def _is_spatial(variants: Mapping[str, Sequence[Phase]]) -> bool:
    return any(is_spatial(phase.experiment.env) for each in variants.values() for phase in each)


def _plain(given: Mapping[str, Sequence[Benchmark]]) -> Table:
    data = tables.table_4(given)
    columns = ("winners", "falls (95 % interval)", "falls of the best winner", "cost of transport")
    return Table(
        name="benchmarks",
        caption="Falls and cost of transport of the winners",
        head="phase",
        columns=tuple(map(Column, columns)),
        groups=(RowGroup("", tuple(Row(str(n), _ours(row)) for n, row in data.iterrows())),),
        data=data[[name for name in data if not str(name).startswith("paper")]].reset_index(),
    )


def _ours(row: Any) -> tuple[Cell, ...]:
    falls = (
        f"{percent(row['fall_rate'])} ({100 * row['fall_rate_low']:.1f} to "
        f"{100 * row['fall_rate_high']:.1f})"
    )
    cost = spread(row["cost_of_transport"], row["cost_of_transport_sd"], 3)
    return cells(f"{row['runs']:.0f}", falls, percent(row["lowest_fall_rate"]), cost)


def _of_paper(
    variants: Mapping[str, Sequence[Phase]], given: Mapping[str, Sequence[Benchmark]]
) -> Table:
    data, spatial = tables.table_4(given), _is_spatial(variants)
    rows: list[Row] = []
    for name, row in data.iterrows():
        *falls, cost = _ours(row)
        fall_rate = quoted(paper.FALL_RATE.get(str(name)), 1, scale=100, unit=" %")
        papers_cost = quoted(paper.COST_OF_TRANSPORT.get(str(name)), 3)
        rows.append(Row(str(name), (*falls, fall_rate, cost, papers_cost)))
    return Table(
        name="benchmarks" if spatial else "table-4",
        caption=f"{'' if spatial else 'Table 4. '}Falls and cost of transport of the winners",
        head="phase",
        columns=(
            Column("winners"),
            Column("falls (95 % interval)"),
            Column("ours", "falls of the best winner"),
            Column("paper", "falls of the best winner"),
            Column("ours", "cost of transport"),
            Column("paper", "cost of transport"),
        ),
        groups=(RowGroup("", tuple(rows)),),
        data=data.reset_index(),
        note=_note(given),
    )


def _note(given: Mapping[str, Sequence[Benchmark]]) -> str:
    """Returns where the paper tells what stands in its columns."""
    told = [
        f"{what} of {name}: {quotes[name].source}"
        for what, quotes in (("falls", paper.FALL_RATE), ("cost", paper.COST_OF_TRANSPORT))
        for name in given
        if name in quotes and quotes[name].value is not None
    ]
    lost = "The body of the paper's table is lost; its text tells of the rest."
    return f"{lost} {'; '.join(told).capitalize()}." if told else lost
