"""When a run may end before its last generation: one of its walkers no longer falls."""

import dataclasses
from typing import Any

import jax
import numpy as np
from jaxtyping import PRNGKeyArray

from mjxwalk.envs import Trials
from mjxwalk.rollout import Outcome, TrialRunner

NUM_CANDIDATES = 4  # ours: the fittest of a generation is often only lucky on its terrain
NUM_EARLY = 64  # ours: trials that are looked at before the others are made
NUM_SCREENING = 8  # ours: on as many terrains most walkers that fall have shown it


@dataclasses.dataclass(frozen=True, kw_only=True)
class Goal:
    """What one of a generation's fittest has to show on new terrains for its run to end there.

    Attributes:
      trials: that are tried; 0 for no goal.
      share: of them that must end without a fall, last so long and get so far.
      duration: that each of them lasts at least, s.
      distance: that each of them covers at least, m; who only stands does not fall either.
      fine_trials: further trials that it has to pass at a finer time step, since some gaits hang
        on the step that they evolved at (docs/physics.md); 0 for none.
      fine_factor: divides the time step there.
    """

    trials: int = 0
    share: float = 1.0
    duration: float = 0.0
    distance: float = 0.0
    fine_trials: int = 0
    fine_factor: int = 4

    def __post_init__(self) -> None:
        for name in ("trials", "fine_trials"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} must be 0 or above, got {getattr(self, name)}")
        if not 0.0 < self.share <= 1.0:
            raise ValueError(f"share must be above 0 and at most 1, got {self.share}")
        if self.fine_factor < 2:
            raise ValueError(f"fine_factor must be 2 or above, got {self.fine_factor}")
        for name in ("duration", "distance"):
            value = getattr(self, name)
            if not value >= 0:
                raise ValueError(f"{name} must be 0 or above, got {value}")

    @property
    def is_fine(self) -> bool:
        """Whether there are trials at a finer time step."""
        return self.trials > 0 and self.fine_trials > 0

    def find(
        self,
        experiment: Any,
        evaluator: TrialRunner,
        population: Any,
        outcome: Outcome,
        keys: tuple[PRNGKeyArray, PRNGKeyArray],
        finer: TrialRunner | None = None,
    ) -> int | None:
        """Returns the place of a genotype that passes all trials, None where there is none.

        The fittest of those that passed the trials of their generation are tried on a few terrains;
        of those that pass there, the one that gets farthest is tried on the others, and then at
        the finer time step. The terrains are of the environment's own roughness.

        Args:
          experiment: what samples trials.
          evaluator: tries the genotypes.
          population: of the generation, leaves [pop, ...].
          outcome: of the generation, numpy arrays [pop, trial].
          keys: of the terrains and of those of the fine trials, used up.
          finer: tries genotypes at the finer time step.

        Raises:
          ValueError: there are fine trials, and nothing that makes them.
        """
        if self.is_fine and finer is None:
            raise ValueError(f"fine_trials is {self.fine_trials} and nobody runs them")
        key, key_fine = keys
        hopeful = np.flatnonzero(self._passed(outcome))
        if self.trials == 0 or not hopeful.size:
            return None
        fitness = outcome.fitness[hopeful].mean(axis=1)
        # Always as many, in case of need the same one again: what is compiled for it then serves.
        places = np.resize(hopeful[np.argsort(-fitness, kind="stable")], NUM_CANDIDATES)
        trials: Trials = experiment.sample_trials(key, self.trials)
        screened = evaluator.evaluate(take(population, places), trials.take(slice(NUM_SCREENING)))
        passed = self._passed(screened)
        if not passed.any():
            return None
        distance = np.where(passed, screened.distance.mean(axis=1), -np.inf)
        place = places[[np.argmax(distance)]]
        walker = take(population, place)
        # Who falls now and then has mostly done so on the first of them.
        for part in (trials.take(slice(NUM_EARLY)), trials.take(slice(NUM_EARLY, None))):
            if part.num and not self._passed(evaluator.evaluate(walker, part)).all():
                return None
        if self.is_fine and finer is not None:
            fine = experiment.sample_trials(key_fine, self.fine_trials)
            if not self._passed(finer.evaluate(walker, fine)).all():
                return None
        return int(place[0])

    def _passed(self, outcome: Outcome) -> Any:
        short = (outcome.duration < self.duration) | (outcome.distance < self.distance)
        return np.mean(~(outcome.fell | short), axis=1) >= self.share


def take(population: Any, places: Any) -> Any:
    """Returns the genotypes at some places of a population."""
    return jax.tree.map(lambda leaf: np.asarray(leaf)[places], population)
