"""What to make of a tournament's figures, in words."""

from mjxwalk.tournament.results import (
    AS_EVOLVED,
    HALF_STEP,
    PAPERS_STEP,
    PERTURBED,
    Condition,
    Tournament,
)

# ours: a gait is another one where the intervals of its fall rates lie farther apart than this, or
# it gets so much less far or farther; who stands still in the end does not fall.
MARGIN = 0.03
DISTANCE_MARGIN = 0.1  # of the usual distance


def remarks(tournament: Tournament) -> list[str]:
    """Returns what the figures say of the gait, a sentence each."""
    usual = tournament.condition(AS_EVOLVED)
    if usual is None:
        return []
    apart = otherwise(tournament)
    names = [each.name for each in tournament.conditions if each is not usual]
    same = [name for name in names if name not in apart]
    if usual.fall_rate == 1.0 and not apart:
        return [f"falls in every trial, after {usual.distance_mean_m:.1f} m as evolved"]
    found: list[str] = []
    steps = [name for name in (HALF_STEP, PAPERS_STEP) if name in apart]
    if steps:
        found.append(
            f"the gait is an artefact of its time step: falls {_outcome(usual)} as evolved, "
            f"{' and '.join(f'{_outcome(apart[name])} at {name}' for name in steps)}"
        )
    if PERTURBED in apart:
        found.append(
            f"the gait depends on its initial pose: falls {_outcome(usual)} from the usual one, "
            f"{_outcome(apart[PERTURBED])} from {PERTURBED}"
        )
    if same:
        found.append(f"walks alike at {', '.join(same)}")
    return found


def otherwise(tournament: Tournament) -> dict[str, Condition]:
    """Returns the conditions, by name, under which the gait is another than as it evolved.

    Of a walker that always falls there is no gait that could be another.
    """
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
        f"cost of transport {number(usual.cost_of_transport, 2)}"
    )
    if half is not None:
        line += f", falls {percent(half.fall_rate)} at half the step"
    return line


def percent(share: float) -> str:
    """Returns a share in words."""
    return f"{100 * share:.1f} %"


def _differ(usual: Condition, other: Condition) -> bool:
    low, high = sorted((usual, other), key=lambda each: each.fall_rate)
    if low.fall_rate == 1.0:
        return False
    farther = abs(other.distance_mean_m - usual.distance_mean_m)
    return high.fall_rate_low > low.fall_rate_high + MARGIN or farther > DISTANCE_MARGIN * abs(
        usual.distance_mean_m
    )


def _outcome(condition: Condition) -> str:
    return f"{percent(condition.fall_rate)} ({condition.distance_mean_m:.1f} m)"


def number(value: float | None, digits: int) -> str:
    """Returns a figure in words."""
    return "-" if value is None else f"{value:.{digits}f}"
