"""A tournament in words: a table on a terminal, plain lines elsewhere, and what to make of it."""

import sys

from mjxwalk import terminal
from mjxwalk.tournament.results import (
    AS_EVOLVED,
    HALF_STEP,
    PAPERS_STEP,
    PERTURBED,
    Condition,
    Tournament,
)

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

# ours: a gait is another one where the intervals of its fall rates lie farther apart than this, or
# it gets so much less far or farther; who stands still in the end does not fall.
MARGIN = 0.03
DISTANCE_MARGIN = 0.1  # of the usual distance


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


def remarks(tournament: Tournament) -> list[str]:
    """Returns what the figures say of the gait, a sentence each."""
    usual = tournament.condition(AS_EVOLVED)
    if usual is None:
        return []
    apart = otherwise(tournament)
    found: list[str] = []
    steps = [name for name in (HALF_STEP, PAPERS_STEP) if name in apart]
    if steps:
        found.append(
            f"the gait is an artefact of its time step: falls {_outcome(usual)} as evolved, "
            f"{' and '.join(f'{_outcome(apart[name])} at {name}' for name in steps)}"
        )
    if PERTURBED in apart:
        found.append(
            f"the gait hangs on its start: falls {_outcome(usual)} from the usual one, "
            f"{_outcome(apart[PERTURBED])} from {PERTURBED}"
        )
    names = [each.name for each in tournament.conditions if each is not usual]
    same = [name for name in names if name not in apart]
    if same:
        found.append(f"walks alike at {', '.join(same)}")
    return found


def otherwise(tournament: Tournament) -> dict[str, Condition]:
    """Returns the conditions, by name, under which the gait is another than as it evolved."""
    usual = tournament.condition(AS_EVOLVED)
    if usual is None:
        return {}
    return {
        each.name: each
        for each in tournament.conditions
        if each is not usual and _differ(usual, each)
    }


def figures(tournament: Tournament) -> str:
    """Returns the winner's figures in a line."""
    usual, half = tournament.condition(AS_EVOLVED), tournament.condition(HALF_STEP)
    if usual is None:
        return "no figures"
    line = (
        f"{usual.distance_mean_m:.1f} m, falls {percent(usual.fall_rate)}, "
        f"cost of transport {_number(usual.cost_of_transport, 2)}"
    )
    if half is not None:
        line += f", falls {percent(half.fall_rate)} at half the step"
    return line


def percent(share: float) -> str:
    """Returns a share in words."""
    return f"{100 * share:.1f} %"


def _differ(usual: Condition, other: Condition) -> bool:
    low, high = sorted((usual, other), key=lambda each: each.fall_rate)
    farther = abs(other.distance_mean_m - usual.distance_mean_m)
    return high.fall_rate_low > low.fall_rate_high + MARGIN or farther > DISTANCE_MARGIN * abs(
        usual.distance_mean_m
    )


def _outcome(condition: Condition) -> str:
    return f"{percent(condition.fall_rate)} ({condition.distance_mean_m:.1f} m)"


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
        _number(condition.cost_of_transport, 3),
        _number(condition.speed_m_s, 2),
        _number(condition.step_length_m, 3),
        "-" if share is None else percent(share),
    )


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _show_table(rows: list[tuple[str, ...]]) -> None:
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for place, column in enumerate(COLUMNS):
        table.add_column(column, justify="left" if place == 0 else "right")
    for row in rows:
        table.add_row(*row)
    terminal.console().print(table)
