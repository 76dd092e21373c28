"""An agreement in words."""

from mjxwalk.tournament.remarks import percent
from mjxwalk.verify.agreement import MOST_APART, MOST_APART_COST, MOST_OTHER_ENDS, Agreement, Side

COLUMNS = ("", "distance (m)", "falls", "cost of transport")


def show(agreement: Agreement) -> None:
    """Prints how an engine and C MuJoCo agree."""
    print_rows([COLUMNS, _row(agreement.engine), _row(agreement.reference)])
    print(conclusion(agreement))


def print_rows(rows: list[tuple[str, ...]]) -> None:
    """Prints rows of as many cells each in columns."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=True)]
        print("  " + "  ".join(cells).rstrip())


def conclusion(agreement: Agreement) -> str:
    """Returns what the figures say, in a sentence."""
    cost = agreement.cost_apart
    apart = (
        f"distances {percent(agreement.distance_apart)} apart on average (in the median trial "
        f"{percent(agreement.trial_apart)}), costs "
        f"{'not comparable' if cost is None else percent(cost) + ' apart'}, "
        f"{agreement.other_ends} of {len(agreement.engine.fell)} trials end otherwise"
    )
    if agreement.agrees:
        return f"agrees: {apart}"
    return (
        f"does not agree: {apart}; allowed are {percent(MOST_APART)}, {percent(MOST_APART_COST)} "
        f"and {percent(MOST_OTHER_ENDS)} of the trials"
    )


def _row(side: Side) -> tuple[str, ...]:
    cost = side.cost_of_transport
    falls = f"{sum(side.fell)} of {len(side.fell)}"
    return (
        side.name,
        f"{side.distance_mean_m:.3f}",
        falls,
        "-" if cost is None else f"{cost:.4f}",
    )
