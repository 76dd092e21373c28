"""A tournament in words: a table on a terminal, plain lines elsewhere, and what to make of it."""

import sys

from mjxwalk import terminal
from mjxwalk.tournament import Condition, Tournament
from mjxwalk.tournament.remarks import number, percent, remarks

COLUMNS = (
    "conditions",
    "trials",
    "distance (m)",
    "falls (95 % interval)",
    "cost of transport",
    "speed (m/s)",
    "step (m)",
    "double stance",
)


def show(tournament: Tournament, source: str) -> None:
    """Prints a tournament."""
    print(_headline(tournament, source))
    rows = [_row(condition) for condition in tournament.conditions]
    if sys.stdout.isatty():
        _show_table(rows)
    else:
        widths = [max(map(len, column)) for column in zip(COLUMNS, *rows, strict=True)]
        for row in (COLUMNS, *rows):
            first, *rest = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
            print("  " + "  ".join([first, *rest]).rstrip())
    for remark in remarks(tournament):
        print(remark)


def _headline(tournament: Tournament, source: str) -> str:
    winner = f"the winner of {source} is the fittest of generation {tournament.winner_generation}"
    if tournament.screening_terrains:
        winner += f", of {tournament.entrants} on {tournament.screening_terrains} terrains"
    rough = tournament.roughness_m
    return winner if rough is None else f"{winner}; roughness {rough:g} m"


def _row(condition: Condition) -> tuple[str, ...]:
    low, high = 100 * condition.fall_rate_low, 100 * condition.fall_rate_high
    share = condition.double_stance
    return (
        condition.name,
        str(condition.trials),
        f"{condition.distance_mean_m:.2f} ± {condition.distance_sd_m:.2f}",
        f"{percent(condition.fall_rate)} ({low:.1f} to {high:.1f})",
        number(condition.cost_of_transport, 3),
        number(condition.speed_m_s, 2),
        number(condition.step_length_m, 3),
        "-" if share is None else percent(share),
    )


def _show_table(rows: list[tuple[str, ...]]) -> None:
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for place, column in enumerate(COLUMNS):
        table.add_column(column, justify="left" if place == 0 else "right")
    for row in rows:
        table.add_row(*row)
    terminal.console().print(table)
