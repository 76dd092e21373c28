"""When a run may end before its last generation: its fittest walker no longer falls."""

import dataclasses
from typing import Any, Protocol, runtime_checkable

import jax
import numpy as np
from jaxtyping import PRNGKeyArray

from mjxwalk.rollout import Outcome

NUM_SCREENING = 20  # ours: on as many terrains most walkers that fall have shown it


@runtime_checkable
class Trying(Protocol):
    """Runs a study's rollout for populations."""

    def evaluate(self, population: Any, heights: Any, /) -> Outcome:
        """Returns the outcomes as numpy arrays [pop, terrain]."""
        ...


@dataclasses.dataclass(frozen=True, kw_only=True)
class Goal:
    """What a generation's fittest has to show on new terrains for its run to end there.

    Attributes:
      trials: none of which may end by a fall; 0 for no goal.
      duration: that each of them lasts at least, s.
    """

    trials: int = 0
    duration: float = 0.0

    def __post_init__(self) -> None:
        if self.trials < 0:
            raise ValueError(f"trials must be 0 or above, got {self.trials}")
        if not self.duration >= 0:
            raise ValueError(f"duration must be 0 or above, got {self.duration}")

    def reached(
        self, study: Any, evaluator: Trying, genotype: Any, key: PRNGKeyArray, generation: int
    ) -> bool:
        """Returns whether the genotype passes all trials; False where there is no goal."""
        if self.trials == 0:
            return False
        terrains = study.sample_terrains(key, self.trials, generation)
        alone = jax.tree.map(lambda leaf: np.asarray(leaf)[None], genotype)
        for num in (min(NUM_SCREENING, self.trials), self.trials):
            outcome = evaluator.evaluate(
                alone, jax.tree.map(lambda leaf, n=num: leaf[:n], terrains)
            )
            if outcome.fell.any() or np.any(outcome.duration < self.duration):
                return False
        return True
