"""Tests of a generation's figures against hand-worked cases."""

import numpy as np
import pytest

from mjxwalk.evolution.generation_metrics import measure
from mjxwalk.rollout import Outcome


def outcome(fitness: list[list[float]]) -> Outcome:
    values = np.array(fitness, np.float32)
    ones = np.ones_like(values)
    fell = values < 0
    arrays = (values, values, ones, fell, ~fell, ones, ones, ones.astype(np.int32))
    return Outcome(*arrays)  # type: ignore[arg-type]


def test_nan_stays_out_of_the_averages() -> None:
    line = measure(
        outcome([[1.0, 3.0], [np.nan, 1.0], [-1.0, -3.0]]),
        0,
        generation=1,
        weight=10.0,
        told={
            "fitness": {"num_nan": np.int32(1)},
            "sigma": np.float32(0.5),
            "spread": np.ones(3),
        },
        evaluate_s=2.0,
        compile_s=0.0,
        other_s=0.0,
    )
    assert (line.best_fitness, line.mean_fitness, line.median_fitness) == (2.0, 0.0, 0.0)
    assert line.fall_share == pytest.approx(1 / 3)
    assert line.physics_steps == 6
    assert line.steps_per_s == 3.0
    assert line.strategy == {"num_nan": 1.0, "sigma": 0.5}


def test_a_generation_without_any_fitness_has_none() -> None:
    line = measure(
        outcome([[np.nan], [np.nan]]),
        0,
        generation=1,
        weight=10.0,
        told=(),
        evaluate_s=0.0,
        compile_s=0.0,
        other_s=0.0,
    )
    assert (line.best_fitness, line.mean_fitness, line.median_fitness) == (None, None, None)
