"""Tests of the conditions that a planar walker is tried under."""

import dataclasses

import jax
import numpy as np
import pytest

from mjxwalk import experiments, tournament
from mjxwalk.tournament import conditions
from mjxwalk.tournament.entrants import Entrants
from mjxwalk.tournament.results import AS_EVOLVED, HALF_STEP, PAPERS_STEP, PERTURBED

LPD = experiments.get("planar-lpd")
SHORT = dataclasses.replace(LPD, env=dataclasses.replace(LPD.env, max_time=0.3))


def test_conditions_differ_in_what_they_are_named_for_only() -> None:
    trials = SHORT.sample_trials(jax.random.key(0), 12)
    usual, half, papers, started = conditions.settings(SHORT, trials, jax.random.key(1))
    assert (usual.name, half.name, papers.name, started.name) == (
        AS_EVOLVED,
        HALF_STEP,
        PAPERS_STEP,
        PERTURBED,
    )
    assert usual.experiment == SHORT
    assert half.experiment.env == dataclasses.replace(SHORT.env, timestep=0.0005)
    explicit = dataclasses.replace(SHORT.env, timestep=0.0002, integrator="explicit")
    assert papers.experiment.env == explicit
    assert started.experiment.env == SHORT.env
    assert [each.trials.num for each in (usual, half, papers, started)] == [12, 12, 3, 12]
    np.testing.assert_array_equal(papers.trials.heights, trials.heights[:3])
    np.testing.assert_array_equal(started.trials.heights, trials.heights)
    assert all(each.trials.start is None for each in (usual, half, papers))
    assert started.trials.start.shape == (12, 3) and np.ptp(started.trials.start) > 1.0


@pytest.mark.slow  # compiles the physics four times
def test_a_planar_walker_is_tried_under_all_conditions() -> None:
    weights = jax.tree.map(lambda leaf: np.zeros((1, *leaf.shape), np.float32), SHORT.template())
    still = Entrants(name="still", experiment=SHORT, genotypes=weights, generations=np.array([1]))
    held = tournament.compete(still, engine="lanes", terrains=10)
    assert [each.trials for each in held.conditions] == [10, 10, 2, 10]
    usual, half, papers, started = (each.distance_mean_m for each in held.conditions)
    # Without torque the body sinks alike at any step: 0.3 s are a few centimetres.
    assert half == pytest.approx(usual, abs=2e-3)
    assert papers == pytest.approx(usual, abs=2e-3)
    assert abs(started - usual) > 1e-4
