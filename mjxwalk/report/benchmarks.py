"""What walking costs and how often walkers fall: Table 4 of Solomon, Locascio & Hartmann (2013)."""

from collections.abc import Mapping, Sequence

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
    percent,
    quoted,
    spread,
)
from mjxwalk.report.sources import Phase


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
        parts=(_table(given, spatial=_is_spatial(variants)),) if given else (),
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


def _table(given: Mapping[str, Sequence[Benchmark]], *, spatial: bool) -> Table:
    data = tables.table_4(given)
    rows = [
        Row(
            str(name),
            (
                Cell(f"{row['runs']:.0f}"),
                Cell(
                    f"{percent(row['fall_rate'])} ({100 * row['fall_rate_low']:.1f} to "
                    f"{100 * row['fall_rate_high']:.1f})"
                ),
                Cell(percent(row["lowest_fall_rate"])),
                quoted(paper.FALL_RATE.get(str(name)), 1, scale=100, unit=" %"),
                Cell(spread(row["cost_of_transport"], row["cost_of_transport_sd"], 3)),
                quoted(paper.COST_OF_TRANSPORT.get(str(name)), 3),
            ),
        )
        for name, row in data.iterrows()
    ]
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
