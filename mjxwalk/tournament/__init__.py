"""Tournaments: which of a run's elites walks best on new ground, and how well it does elsewhere.

Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient 2D and 3D bipedal
walking over rough terrain", Adaptive Behavior 21(1), section 2.7.3.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from mjxwalk.tournament.entrants import Entrants
from mjxwalk.tournament.results import Condition, Tournament, read

SCREENING = 20  # section 2.7.3: terrains on which the entrants are compared
TERRAINS = 1000  # section 2.7.3: further ones on which the winner is reported


def _silent(text: str) -> None:
    del text


def compete(
    entrants: Entrants,
    *,
    engine: str = "auto",
    seed: int = 0,
    screening: int = SCREENING,
    terrains: int = TERRAINS,
    say: Callable[[str], None] = _silent,
) -> Tournament:
    """Returns the winner and its figures; imports JAX.

    The winner's weights are `entrants.of_generation(tournament.winner_generation)`.

    Args:
      entrants: that compete.
      engine: that runs the trials.
      seed: of terrains and starts.
      screening: terrains on which all entrants are compared.
      terrains: further ones on which the winner is tried, under each of the conditions.
      say: is told what begins.

    Raises:
      ValueError: there is no such engine, or a number is wrong.
    """
    from mjxwalk.tournament import competition

    return competition.compete(
        entrants, engine=engine, seed=seed, screening=screening, terrains=terrains, say=say
    )


def write(folder: Path, tournament: Tournament, genotype: Any) -> None:
    """Writes a run's `winner.npz` and `tournament.json`; imports JAX.

    Raises:
      RunError: the files cannot be written, for example because the disk is full.
    """
    from mjxwalk.runs.trees import flatten
    from mjxwalk.tournament import results

    results.write(folder, tournament, flatten(genotype))


__all__ = ["SCREENING", "TERRAINS", "Condition", "Tournament", "compete", "read", "write"]
