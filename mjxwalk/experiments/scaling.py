"""A smaller or larger edition of an experiment, for a first look."""

import dataclasses
import math
from typing import Any, TypeVar, cast

# ours: below these a phase loses its structure: parents to choose from, something to compare with.
SMALLEST_POPULATION = 10
FEWEST_GENERATIONS = 2
LARGEST = 1e4  # factor; ours: days of a generation of the default
STEEPEST = 1e9  # of a ramp, which is at its end after one step; ours

T = TypeVar("T")


def scaled(experiment: T, factor: float) -> T:
    """Returns the experiment with its population and all its counts of generations scaled.

    Args:
      experiment: a frozen dataclass with the fields of an `Experiment`; those that it lacks are
        passed over.
      factor: above 0; 1 changes nothing.

    Raises:
      ValueError: the factor is too small or too large.
    """
    if not 0 < factor <= LARGEST:
        raise ValueError(f"scale must be above 0 and at most {LARGEST:g}, got {factor}")
    given = cast("Any", experiment)

    def count(value: int, fewest: int = 1) -> int:
        # What the floor would raise was small on purpose and stays.
        return max(min(value, fewest), round(value * factor))

    changes: dict[str, object] = {
        "population_size": count(given.population_size, SMALLEST_POPULATION),
        "generations": count(given.generations, FEWEST_GENERATIONS),
    }
    if getattr(given, "pruning", None) is not None:
        pruning = given.pruning
        numbers = {n: count(getattr(pruning, n)) for n in ("every", "reference", "window")}
        changes["pruning"] = dataclasses.replace(
            pruning, **numbers, settle=count(pruning.settle, FEWEST_GENERATIONS)
        )
    if getattr(given, "ramp", None) is not None:
        ramp = given.ramp
        # As far in fewer generations.
        is_steep = math.log(ramp.factor) / factor > math.log(STEEPEST)
        steeper = STEEPEST if is_steep else ramp.factor ** (1 / factor)
        changes["ramp"] = dataclasses.replace(ramp, factor=steeper)
    if getattr(given, "restart_after", None) is not None:
        after = count(given.restart_after, FEWEST_GENERATIONS)
        changes["restart_after"] = after
        if given.restart_at is not None:
            changes["restart_at"] = max(after + 1, count(given.restart_at))
    return cast("T", dataclasses.replace(given, **changes))
