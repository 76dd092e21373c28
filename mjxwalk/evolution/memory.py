"""What a population takes of the machine's memory, found out before it is taken."""

import math
from typing import Any

import jax

from mjxwalk import budget
from mjxwalk.experiments.goal import NUM_CANDIDATES

OUTCOME = 32  # bytes of what a trial gives, as many as `Outcome` has


def check(arrays: Any) -> None:
    """Raises RunError unless arrays fit into this machine's memory.

    Args:
      arrays: anything with their shapes and types.
    """
    # One at a time of these is enough to be sure; how many more there are depends on the strategy.
    budget.check(
        _bytes(arrays), "the population and its strategy take", "set a smaller --population"
    )


def check_settings(experiment: Any) -> None:
    """Raises RunError unless the trials of a generation, and of the goal, fit into memory.

    It computes nothing, so that it can be asked before anything is made.

    Args:
      experiment: an `Evolvable`.
    """
    goal, growth = experiment.goal, getattr(experiment, "growth", None)
    size = getattr(experiment, "population_size", 1) if growth is None else growth.part
    rounds = (
        (size, experiment.terrains_per_evaluation),
        (NUM_CANDIDATES, goal.trials),
        (1, goal.fine_trials),
    )
    for walkers, terrains in rounds:
        check_trials(experiment.template(), walkers, terrains)
        budget.check_grounds(getattr(experiment, "env", None), terrains)


def check_trials(genotype: Any, walkers: int, terrains: int) -> None:
    """Raises RunError unless walkers fit into memory, with a copy for each of their terrains."""
    budget.check(
        float(walkers) * terrains * (_bytes(genotype) + OUTCOME),
        f"{walkers:,} walkers on {terrains:,} terrains each take",
        "set a smaller --population, or fewer terrains or trials",
    )


def _bytes(arrays: Any) -> int:
    leaves = jax.tree.leaves(arrays)
    return sum(math.prod(leaf.shape) * leaf.dtype.itemsize for leaf in leaves)
