"""Returns of a policy's episodes in words."""

from mjxwalk.cli.verify_table import print_rows
from mjxwalk.tournament.remarks import percent
from mjxwalk.verify.returns import LEAST_P, Played, Returns

COLUMNS = ("", "mean return", "deviation", "median", "quartiles", "terminated", "mean steps")


def show(played: Played) -> None:
    """Prints what a policy earns by an engine and in Gymnasium's own environment."""
    print_rows([COLUMNS, _row(played.engine), _row(played.reference)])
    print(conclusion(played))


def conclusion(played: Played) -> str:
    """Returns what the figures say, in a sentence."""
    agreement = "agrees" if played.agrees else "does not agree"
    return (
        f"{agreement}: if the returns were of one distribution, two samples would be at least so "
        f"far apart with a probability of {played.p_value:.2g} (Kolmogorov-Smirnov test; below "
        f"{LEAST_P:g} they count as different)"
    )


def _row(side: Returns) -> tuple[str, ...]:
    return (
        side.name,
        f"{side.mean:.1f}",
        f"{side.deviation:.1f}",
        f"{side.median:.1f}",
        f"{side.lower:.1f} to {side.upper:.1f}",
        percent(side.terminated_share),
        f"{side.steps_mean:.0f}",
    )
