"""Tests of the rollout and its evaluation by the mjx engine."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk import experiments
from mjxwalk.evaluation import Evaluator, make_evaluator

LPD = experiments.get("planar-lpd")
# Two tenths of a second: enough to take a first step or to fall.
SHORT = dataclasses.replace(LPD, env=dataclasses.replace(LPD.env, max_time=0.2))
POPULATION_SIZE, NUM_TERRAINS = 5, 3


@pytest.fixture(scope="module")
def evaluator() -> Evaluator:
    return make_evaluator(SHORT, "mjx")


@pytest.fixture(scope="module")
def population() -> Any:
    keys = iter(jax.random.split(jax.random.key(0), 3))
    return jax.tree.map(
        lambda leaf: 0.3 * jax.random.normal(next(keys), (POPULATION_SIZE, *leaf.shape)),
        LPD.template(),
    )


@pytest.fixture(scope="module")
def trials() -> Any:
    return LPD.sample_trials(jax.random.key(1), NUM_TERRAINS)


def test_evaluation_is_every_genotype_on_every_terrain(
    evaluator: Evaluator, population: Any, trials: Any
) -> None:
    outcome = evaluator.evaluate(population, trials)
    assert outcome.fitness.shape == (POPULATION_SIZE, NUM_TERRAINS)
    one = jax.jit(SHORT.rollout)
    for i, j in ((0, 0), (4, 2), (2, 1)):
        genotype = jax.tree.map(lambda leaf, row=i: leaf[row], population)
        alone = one(genotype, trials.given(jnp.asarray(j, jnp.int32)))
        # Compiled for one walker, sums round otherwise; a step is not yet chaos.
        np.testing.assert_allclose(outcome.distance[i, j], alone.distance, atol=1e-3)
        assert abs(int(outcome.steps[i, j]) - int(alone.steps)) <= 2


def test_evaluating_again_gives_the_same_bits(
    evaluator: Evaluator, population: Any, trials: Any
) -> None:
    first, second = (evaluator.evaluate(population, trials) for _ in range(2))
    jax.tree.map(np.testing.assert_array_equal, first, second)


def test_nan_and_huge_weights_end_their_walker_and_leave_the_others_alone(
    evaluator: Evaluator, population: Any, trials: Any
) -> None:
    sound = evaluator.evaluate(population, trials)
    poisoned = population._replace(
        walking=population.walking.at[1].set(jnp.nan).at[3].set(1e30),
        initiation=population.initiation.at[1].set(jnp.nan),
    )
    outcome = evaluator.evaluate(poisoned, trials)
    assert np.all(outcome.fell[1]) and np.all(outcome.diverged[1])
    assert np.all(np.isfinite(outcome.fitness)) and np.all(np.isfinite(outcome.work))
    for i in (0, 2, 4):
        np.testing.assert_array_equal(outcome.fitness[i], sound.fitness[i])


def test_outcome_adds_up(evaluator: Evaluator, population: Any, trials: Any) -> None:
    outcome = evaluator.evaluate(population, trials)
    np.testing.assert_allclose(outcome.duration, outcome.steps * SHORT.env.timestep, rtol=1e-6)
    np.testing.assert_array_equal(outcome.fitness, outcome.distance)
    assert np.all(outcome.steps <= 200) and np.all(outcome.steps > 0)
    assert np.all(outcome.torque_cost >= 0)
