"""Tests of one generation, with the toy's evaluator as the independent reckoning."""

from typing import Any

import jax
import numpy as np
import pytest
import toy

from mjxwalk.evolution import Evolution, RunState
from mjxwalk.evolution.elites import fittest
from mjxwalk.runs import Metrics
from mjxwalk.runs.trees import flatten, unflatten

TOY = toy.Toy()


def advance(num: int, seed: int = 0) -> tuple[RunState, Metrics]:
    evolution = Evolution(TOY, toy.ToyEvaluator(TOY, "auto"))
    state = evolution.start(seed)
    for _ in range(num - 1):
        state, _ = evolution.advance(state)
    return evolution.advance(state)


def same(one: RunState, other: RunState) -> bool:
    pairs = zip(flatten(one).values(), flatten(other).values(), strict=True)
    return all(a.tobytes() == b.tobytes() for a, b in pairs)


def test_the_same_seed_gives_the_same_bits_and_another_does_not() -> None:
    assert same(advance(3)[0], advance(3)[0])
    assert not same(advance(3)[0], advance(3, seed=1)[0])


def test_a_state_that_went_through_the_disk_goes_on_to_the_same_bits() -> None:
    evolution = Evolution(TOY, toy.ToyEvaluator(TOY, "auto"))
    state, _ = evolution.advance(evolution.start(0))
    restored = unflatten(evolution.start(5), flatten(state))
    assert same(evolution.advance(state)[0], evolution.advance(restored)[0])


def test_nothing_is_compiled_after_the_first_generation() -> None:
    evolution = Evolution(TOY, toy.ToyEvaluator(TOY, "auto"))
    state, _ = evolution.advance(evolution.start(0))
    with jax.no_tracing():
        evolution.advance(state)


def test_fitness_is_the_mean_over_the_generation_s_terrains() -> None:
    state, _ = advance(1)
    key = jax.random.fold_in(jax.random.key(0), 1)
    _, key_terrains, _ = jax.random.split(key, 3)
    offsets = np.asarray(TOY.sample_trials(key_terrains, 2).heights, np.float64)
    gain = np.asarray(state.population.gain, np.float64)
    bias = np.asarray(state.population.bias, np.float64)
    squares = [((gain - 1 - off) ** 2).sum((1, 2)) + (bias - 1) ** 2 for off in offsets]
    # float32 sums of seven squares of order one
    np.testing.assert_allclose(state.fitness, -np.mean(squares, axis=0), rtol=1e-5)


def test_metrics_are_those_of_the_fittest_and_of_all() -> None:
    state, line = advance(2)
    assert line.generation == 2
    assert line.best_fitness == state.fitness.max()
    assert line.best_distance_m == pytest.approx(10 + float(state.fitness.max()), rel=1e-6)
    assert line.median_fitness == np.median(state.fitness.astype(np.float64))
    assert line.physics_steps == 16 * 2 * toy.GENERATION_STEPS
    # The toy's trials last 2 s each, and take 40 J at a weight of 10 N.
    assert line.best_distance_m is not None
    assert line.speed_m_s == pytest.approx(line.best_distance_m / 2, rel=1e-6)
    assert line.cost_of_transport == pytest.approx(4 / line.best_distance_m, rel=1e-6)
    assert line.strategy["mean_learning_rate"] is not None


def test_elites_are_the_fittest_of_the_last_generations_newest_last() -> None:
    evolution = Evolution(TOY, toy.ToyEvaluator(TOY, "auto"))
    state = evolution.start(0)
    best: list[np.ndarray] = []
    for _ in range(3):
        state, _ = evolution.advance(state)
        best.append(np.asarray(state.population.gain[np.argmax(state.fitness)]))
    assert state.elites.generation.tolist() == [0] * 47 + [1, 2, 3]
    np.testing.assert_array_equal(state.elites.genotypes.gain[-3:], best)
    np.testing.assert_array_equal(state.elite.gain, best[-1])
    assert state.elites.fitness[-1] == state.fitness.max()


def test_nan_is_never_the_fittest() -> None:
    assert fittest(np.array([np.nan, -5.0, -np.inf], np.float32)) == 1
    assert fittest(np.array([np.nan, np.nan], np.float32)) == 0


def test_the_ground_is_as_rough_as_the_walkers_before_have_earned() -> None:
    asked: list[float] = []  # without a roughness it is only to be compiled

    class Earned(toy.Toy):
        def next_roughness(self, roughness: float, distance: Any) -> float:
            return roughness + float(np.median(distance))

        def sample_trials(self, key: Any, num: int, roughness: float | None = None) -> Any:
            asked.extend([roughness] if roughness is not None else [])
            return super().sample_trials(key, num, roughness)

    experiment = Earned()
    evolution = Evolution(experiment, toy.ToyEvaluator(experiment, "auto"))
    first, _ = evolution.advance(evolution.start(1))
    second, _ = evolution.advance(first)
    # The toy's distance is its fitness and ten.
    expected = experiment.env.terrain.roughness + 10.0 + float(np.median(first.fitness))
    assert asked == pytest.approx([experiment.env.terrain.roughness, expected])
    assert second.roughness == pytest.approx(expected + 10.0 + float(np.median(second.fitness)))
