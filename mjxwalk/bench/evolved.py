"""Real evolution: a population in which walkers fall at very different times."""

from typing import Any

import jax
import numpy as np

from mjxwalk import evaluation
from mjxwalk.bench import bodies
from mjxwalk.engines import lanes
from mjxwalk.envs import Terrain
from mjxwalk.evolution.generation import Evolution
from mjxwalk.experiments.experiment import Experiment


class Evolved:
    """A contender: trials of the last population of a short evolution, on new terrains.

    Attributes:
      mapped: the engine's function of all trials.
      size: trials at once.
    """

    def __init__(self, study: Experiment, generations: int) -> None:
        evolution = Evolution(study, evaluation.make_evaluator(study, "lanes"))
        state = evolution.start(seed=0)
        for _ in range(generations):
            state, _ = evolution.advance(state)
        num = study.terrains_per_evaluation
        heights = study.sample_terrains(jax.random.key(1), num, generations)
        genotypes = jax.tree.map(lambda leaf: np.repeat(leaf, num, 0), state.population)
        self.size = study.population_size * num
        rows = np.arange(self.size, dtype=np.int32) % num
        self._arguments: Any = (genotypes, Terrain(heights, rows))  # type: ignore[arg-type]
        self.mapped = lanes.vmap(study.rollout, bodies.TRIAL_AXES)

    def __call__(self, times: int) -> int:
        """Runs all trials that often and returns how many steps the walkers took."""
        steps = 0
        for _ in range(times):
            outcome = self.mapped(*self._arguments)
            steps += int(outcome.steps.sum(dtype=np.int64))
        return steps
