"""When a run may end before its last generation: one of its walkers no longer falls."""

import dataclasses
from typing import Any, Protocol, runtime_checkable

import jax
import numpy as np
from jaxtyping import PRNGKeyArray

from mjxwalk.rollout import Outcome

NUM_CANDIDATES = 4  # ours: the fittest of a generation is often only lucky on its terrain
NUM_SCREENING = 20  # ours: on as many terrains most walkers that fall have shown it


@runtime_checkable
class Trying(Protocol):
    """Runs a study's rollout for populations."""

    def evaluate(self, population: Any, heights: Any, /) -> Outcome:
        """Returns the outcomes as numpy arrays [pop, terrain]."""
        ...


@dataclasses.dataclass(frozen=True, kw_only=True)
class Goal:
    """What one of a generation's fittest has to show on new terrains for its run to end there.

    Attributes:
      trials: none of which may end by a fall; 0 for no goal.
      duration: that each of them lasts at least, s.
      distance: that each of them covers at least, m; who only stands does not fall either.
    """

    trials: int = 0
    duration: float = 0.0
    distance: float = 0.0

    def __post_init__(self) -> None:
        if self.trials < 0:
            raise ValueError(f"trials must be 0 or above, got {self.trials}")
        for name in ("duration", "distance"):
            value = getattr(self, name)
            if not value >= 0:
                raise ValueError(f"{name} must be 0 or above, got {value}")

    def find(
        self,
        study: Any,
        evaluator: Trying,
        population: Any,
        outcome: Outcome,
        key: PRNGKeyArray,
        generation: int,
    ) -> int | None:
        """Returns the place of a genotype that passes all trials, None where there is none.

        The fittest of those that passed the trials of their generation are tried on a few terrains;
        of those that pass there, the one that gets farthest is tried on the others.

        Args:
          study: what samples terrains.
          evaluator: tries the genotypes.
          population: of the generation, leaves [pop, ...].
          outcome: of the generation, numpy arrays [pop, terrain].
          key: of the terrains, used up.
          generation: its number.
        """
        hopeful = np.flatnonzero(self._passed(outcome))
        if self.trials == 0 or not hopeful.size:
            return None
        fitness = outcome.fitness[hopeful].mean(axis=1)
        # Always as many, in case of need the same one again: what is compiled for it then serves.
        places = np.resize(hopeful[np.argsort(-fitness, kind="stable")], NUM_CANDIDATES)
        terrains = study.sample_terrains(key, self.trials, generation)
        few = jax.tree.map(lambda leaf: leaf[:NUM_SCREENING], terrains)
        screened = evaluator.evaluate(take(population, places), few)
        passed = self._passed(screened)
        if not passed.any():
            return None
        distance = np.where(passed, screened.distance.mean(axis=1), -np.inf)
        place = places[[np.argmax(distance)]]
        if not self._passed(evaluator.evaluate(take(population, place), terrains)).all():
            return None
        return int(place[0])

    def _passed(self, outcome: Outcome) -> Any:
        short = (outcome.duration < self.duration) | (outcome.distance < self.distance)
        return ~np.any(outcome.fell | short, axis=1)


def take(population: Any, places: Any) -> Any:
    """Returns the genotypes at some places of a population."""
    return jax.tree.map(lambda leaf: np.asarray(leaf)[places], population)
