"""Tests of whole trials on a course: each walker has its own, whichever engine walks it."""

import dataclasses
from typing import Any

import jax
import numpy as np
import pytest

from mjxwalk import replay, zoo
from mjxwalk.envs import Course, Gaps, Slope, Stretches
from mjxwalk.evaluation import Evaluator

COURSE = Course(
    slope=Slope(spread=0.03, begin=0.5),
    gaps=Gaps(width=0.1, depth=0.02, begin=1.0, every=1.0, spread=0.4),
    soft=Stretches(factor=0.5, begin=1.0, width=0.5, every=1.0, spread=0.2),
    length=20.0,
)


WALKERS = ["planar-lpd", pytest.param("flame-robust", marks=pytest.mark.slow)]


@pytest.fixture(scope="module", params=WALKERS)
def walked(request: pytest.FixtureRequest) -> tuple[Any, Any, Any]:
    """Returns an experiment whose walker meets a course, the walker alone, and its trials."""
    walker = zoo.load(request.param)
    experiment: Any = walker.experiment.as_tested()
    env = dataclasses.replace(experiment.env, course=COURSE, max_time=3.0)
    experiment = dataclasses.replace(experiment, env=env)
    alone = jax.tree.map(lambda leaf: np.asarray(leaf)[None], walker.genotype)
    return experiment, alone, experiment.sample_trials(jax.random.key(4), 3)


def test_walkers_have_courses_of_their_own(walked: tuple[Any, Any, Any]) -> None:
    experiment, alone, trials = walked
    evaluator = Evaluator(experiment, "lanes")
    together = np.asarray(evaluator.evaluate(alone, trials).distance)[0]
    each = [
        float(evaluator.evaluate(alone, trials.take(np.array([row]))).distance[0, 0])
        for row in range(3)
    ]
    assert together.tolist() == each and len(set(each)) == 3
    level = trials._replace(course=None)
    assert abs(evaluator.evaluate(alone, level).distance[0] - together).max() > 0.01


def test_a_replay_goes_as_far(walked: tuple[Any, Any, Any]) -> None:
    experiment, alone, trials = walked
    outcome = Evaluator(experiment, "lanes").evaluate(alone, trials)
    recording = replay.record(
        experiment.env,
        experiment.controller,
        jax.tree.map(lambda leaf: np.repeat(leaf, 3, axis=0), alone),
        trials.given(np.arange(3, dtype=np.int32)),
        duration=3.0,
        engine="lanes",
    )
    # Steps are compiled otherwise here; a gait carries on what they round otherwise.
    np.testing.assert_allclose(recording.states.qpos[-1, :, 0], outcome.distance[0], rtol=1e-4)


@pytest.mark.slow
def test_engines_agree_on_a_course(walked: tuple[Any, Any, Any]) -> None:
    experiment, alone, trials = walked
    lanes, mjx = (Evaluator(experiment, name).evaluate(alone, trials) for name in ("lanes", "mjx"))
    np.testing.assert_allclose(lanes.distance, mjx.distance, rtol=0.02)
