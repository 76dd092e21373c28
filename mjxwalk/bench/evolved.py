"""Real evolution: populations in which walkers fall at very different times."""

import dataclasses
from typing import Any

import jax
import numpy as np

from mjxwalk import evaluation
from mjxwalk.engines import lanes
from mjxwalk.envs import Terrain
from mjxwalk.evolution import Evolution
from mjxwalk.experiments.experiment import Experiment
from mjxwalk.experiments.goal import Goal


class Evolved:
    """A contender: trials of all populations of a short evolution, on new terrains.

    Attributes:
      size: trials at once.
      lane_utilisation: share of lane-steps that moved a walker, in the latest call.
    """

    def __init__(self, study: Experiment, generations: int) -> None:
        study = dataclasses.replace(study, goal=Goal())  # nobody ends it earlier
        evolution = Evolution(study, evaluation.make_evaluator(study, "lanes"))
        state = evolution.start(seed=0)
        populations: list[Any] = []
        for _ in range(generations):
            state, _ = evolution.advance(state)
            populations.append(state.population)
        num = study.terrains_per_evaluation
        self.size = study.population_size * num
        self.lane_utilisation = 1.0
        keys = jax.random.split(jax.random.key(1), generations)
        self._generations = [
            self._arguments(population, np.asarray(study.sample_terrains(key, num)))
            for population, key in zip(populations, keys, strict=True)
        ]
        self._mapped = lanes.vmap(study.rollout, (0, Terrain(None, 0)))  # type: ignore[arg-type]

    def __call__(self, times: int) -> int:
        """Runs all trials that often and returns how many steps the walkers took."""
        steps, lane_steps = 0, 0.0
        for genotypes, terrain in self._generations * times:
            outcome = self._mapped(genotypes, terrain)
            taken = int(outcome.steps.sum(dtype=np.int64))
            steps += taken
            lane_steps += taken / self._mapped.utilisation
        self.lane_utilisation = steps / lane_steps
        return steps

    def _arguments(self, population: Any, heights: Any) -> tuple[Any, Any]:
        num = len(heights)
        rows: Any = np.arange(self.size, dtype=np.int32) % num
        genotypes = jax.tree.map(lambda leaf: np.repeat(leaf, num, 0), population)
        return genotypes, Terrain(heights, rows)
