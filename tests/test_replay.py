"""Tests of the recorder."""

import dataclasses
from typing import Any

import jax
import numpy as np
import pytest

from mjxwalk import experiments, replay
from mjxwalk.engines import lanes
from mjxwalk.envs import TRIAL_AXES

LPD = experiments.get("planar-lpd")
NUM_WALKERS, NUM_TERRAINS = 5, 3


@pytest.fixture(scope="module")
def genotypes() -> Any:
    keys = iter(jax.random.split(jax.random.key(0), 3))
    return jax.tree.map(
        lambda leaf: np.asarray(0.3 * jax.random.normal(next(keys), (NUM_WALKERS, *leaf.shape))),
        LPD.template(),
    )


@pytest.fixture(scope="module")
def given() -> Any:
    trials = jax.tree.map(np.asarray, LPD.sample_trials(jax.random.key(1), NUM_TERRAINS))
    return trials.given(np.array([0, 1, 2, 0, 1], np.int32))


def record(genotypes: Any, given: Any, **options: Any) -> replay.Recording:
    return replay.record(LPD.env, LPD.controller, genotypes, given, **options)


@pytest.mark.slow
def test_last_frame_is_the_outcome_of_the_rollout(genotypes: Any, given: Any) -> None:
    recording = record(genotypes, given, duration=LPD.env.max_time)
    outcome = lanes.vmap(LPD.rollout, (0, TRIAL_AXES))(genotypes, given)
    assert recording.done[-1].all() and not recording.done[-2].all()
    # The same operations, but LLVM may round sums otherwise in another function.
    np.testing.assert_allclose(recording.states.qpos[-1, :, 0], outcome.distance, atol=1e-3)
    np.testing.assert_allclose(recording.time[-1], outcome.duration, atol=2e-3)
    np.testing.assert_array_equal(recording.states.trial.fell[-1], outcome.fell)


def test_frames_lie_a_frame_apart_until_the_end_and_then_repeat(genotypes: Any, given: Any) -> None:
    recording = record(genotypes, given, duration=1.5, frames_per_second=50.0)
    for walker in range(NUM_WALKERS):
        going = ~recording.done[:, walker]
        expected = 0.02 * np.arange(going.sum())
        np.testing.assert_allclose(recording.time[going, walker], expected, atol=1e-5)
        after = recording.states.qpos[~going, walker]
        np.testing.assert_array_equal(after, np.repeat(after[:1], len(after), 0))
    np.testing.assert_array_equal(recording.done, np.sort(recording.done, axis=0))


def test_frames_are_the_same_at_every_rate_and_duration(genotypes: Any, given: Any) -> None:
    often = record(genotypes, given, duration=0.3, frames_per_second=100.0)
    seldom = record(genotypes, given, duration=0.24, frames_per_second=25.0)
    assert len(often.time) == 31 and len(seldom.time) == 7
    jax.tree.map(np.testing.assert_array_equal, seldom.states, jax.tree.map(
        lambda leaf: leaf[:25:4], often.states
    ))  # fmt: skip


def test_a_walker_alone_walks_as_among_others(genotypes: Any, given: Any) -> None:
    together = record(genotypes, given, duration=0.3)
    alone = record(
        jax.tree.map(lambda leaf: leaf[3:4], genotypes),
        given._replace(ground=given.ground._replace(row=given.ground.row[3:4])),
        duration=0.3,
    )
    np.testing.assert_array_equal(
        alone.states.qpos[:, 0], together.states.qpos[: len(alone.time), 3]
    )


@pytest.mark.slow
def test_engines_agree(genotypes: Any, given: Any) -> None:
    ours = record(genotypes, given, duration=0.1, engine="lanes")
    reference = record(genotypes, given, duration=0.1, engine="mjx")
    # A tenth of a second is not yet chaos.
    np.testing.assert_allclose(ours.states.qpos, reference.states.qpos, atol=1e-4)


@pytest.mark.slow
def test_the_spatial_body_is_recorded_too() -> None:
    spatial = experiments.get("solomon-3d")
    given = spatial.sample_trials(jax.random.key(0), 1).given(np.zeros(2, np.int32))
    genotypes = jax.tree.map(lambda leaf: np.stack([leaf] * 2), spatial.template())
    recording = replay.record(spatial.env, spatial.controller, genotypes, given, duration=0.05)
    assert recording.states.qpos.shape == (6, 2, 15)
    short: Any = dataclasses.replace(spatial.env, max_time=0.05)
    rollout = dataclasses.replace(spatial, env=short).rollout
    outcome = lanes.vmap(rollout, (0, TRIAL_AXES))(genotypes, given)
    np.testing.assert_allclose(recording.states.qpos[-1, :, 0], outcome.distance, atol=1e-5)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"frames_per_second": 0.0}, "frames_per_second must be above 0 and at most 1000"),
        ({"frames_per_second": 5000.0}, "frames_per_second must be above 0 and at most 1000"),
        ({"duration": 0.0}, "duration must be a frame at least, got 0.0"),
        ({"engine": "magic"}, "engine must be one of"),
    ],
)
def test_bad_settings_are_named(
    options: dict[str, Any], message: str, genotypes: Any, given: Any
) -> None:
    with pytest.raises(ValueError, match=message):
        record(genotypes, given, **({"duration": 0.1} | options))
