"""Real evolution: populations in which walkers fall at very different times."""

import dataclasses
from typing import Any

import jax
import numpy as np

from mjxwalk import evaluation
from mjxwalk.engines import lanes
from mjxwalk.envs import TRIAL_AXES, Trial, Trials
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
            self._arguments(population, jax.tree.map(np.asarray, study.sample_trials(key, num)))
            for population, key in zip(populations, keys, strict=True)
        ]
        self._mapped = lanes.vmap(study.rollout, (0, TRIAL_AXES))

    def __call__(self, times: int) -> int:
        """Runs all trials that often and returns how many steps the walkers took."""
        steps, lane_steps = 0, 0.0
        for genotypes, given in self._generations * times:
            outcome = self._mapped(genotypes, given)
            taken = int(outcome.steps.sum(dtype=np.int64))
            steps += taken
            lane_steps += taken / self._mapped.utilisation
        self.lane_utilisation = steps / lane_steps
        return steps

    def _arguments(self, population: Any, trials: Trials) -> tuple[Any, Trial]:
        rows = np.arange(self.size, dtype=np.int32) % trials.num
        genotypes = jax.tree.map(lambda leaf: np.repeat(leaf, trials.num, 0), population)
        return genotypes, trials.given(rows)
