"""Tests of measuring gaits over trials."""

import warnings

import jax
import numpy as np
import pytest
from analysis.walking import recording, stand, walk

from mjxwalk.analysis import gait
from mjxwalk.analysis.footfalls import find_footfalls, observe
from mjxwalk.envs import Flame, Planar7
from mjxwalk.replay import Recording

ENV = Planar7()


def test_a_known_gait_has_its_numbers() -> None:
    measured = gait.measure_gait(recording([walk(), walk(900)], fell=[False, False]), ENV)
    assert (measured.trials, measured.falls) == (2, 0)
    assert measured.strides == 7 + 12
    # Positions and times are float32; the hip starts and ends in the middle of a step.
    np.testing.assert_allclose(measured.step_length_m.mean, 0.6, rtol=1e-5)
    np.testing.assert_allclose(measured.double_stance.mean, 0.2, rtol=1e-4)
    np.testing.assert_allclose(measured.stride_time_s.mean, 1.2, rtol=1e-5)
    np.testing.assert_allclose(measured.swing_time_s.mean, 0.48, rtol=1e-4)
    np.testing.assert_allclose(measured.speed_m_s.mean, 1.0, rtol=0.02)
    np.testing.assert_allclose(measured.step_length_m.sd, 0.0, atol=1e-5)


def test_cost_of_transport_is_work_over_weight_times_distance() -> None:
    made = recording([walk()], fell=[False], work=2000.0)
    distance = made.states.qpos[-1, 0, 0] - made.states.qpos[0, 0, 0]
    measured = gait.measure_gait(made, ENV)
    expected = 2000.0 / (70.0 * 9.81 * distance)  # the body weighs 70 kg
    np.testing.assert_allclose(measured.cost_of_transport.mean, expected, rtol=1e-5)


def test_trials_with_a_fall_count_as_falls_only() -> None:
    slow = walk(600, stance=90)
    made = recording([walk(), slow._replace(time=slow.time)], fell=[False, True])
    measured = gait.measure_gait(made, ENV)
    assert (measured.trials, measured.falls, measured.strides) == (2, 1, 7)
    np.testing.assert_allclose(measured.double_stance.mean, 0.2, rtol=1e-4)
    assert measured.double_stance.num == 1 and np.isnan(measured.double_stance.sd)


def test_a_fall_in_the_middle_ends_the_strides_there() -> None:
    whole = walk()
    cut = whole._replace(
        time=whole.time[:250], contact=whole.contact[:250], ankle_x=whole.ankle_x[:250]
    )
    trials = gait.measure_trials(recording([whole, cut], fell=[False, True]), ENV)
    assert trials["strides"].tolist() == [7, 2]
    assert trials["fell"].tolist() == [False, True]
    np.testing.assert_allclose(trials["duration_s"], [5.99, 2.49], rtol=1e-6)


@pytest.mark.parametrize("frames", [1, 300])
def test_a_standing_walker_has_no_figures_of_strides(frames: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        measured = gait.measure_gait(recording([stand(frames)], fell=[False]), ENV)
    assert measured.strides == 0
    for name in ("step_length_m", "double_stance", "stride_time_s", "cost_of_transport"):
        assert np.isnan(getattr(measured, name).mean) and getattr(measured, name).num == 0
    assert np.isnan(measured.speed_m_s.mean) if frames == 1 else measured.speed_m_s.mean == 0.0


def test_a_walker_that_always_falls_has_no_figures() -> None:
    measured = gait.measure_gait(recording([walk(), walk()], fell=[True, True]), ENV)
    assert (measured.trials, measured.falls, measured.strides) == (2, 2, 0)
    assert all(np.isnan(getattr(measured, name).mean) for name in gait.FIGURES)


def test_deviations_across_winners_are_between_their_means() -> None:
    one, other = (
        gait.measure_gait(recording([walk(stance=stance)] * 3, fell=[False] * 3), ENV)
        for stance in (72, 78)
    )
    both = gait.across([one, other])
    assert (both.trials, both.strides) == (6, 42)
    np.testing.assert_allclose(both.double_stance.mean, (0.2 + 0.3) / 2, rtol=1e-4)
    np.testing.assert_allclose(both.double_stance.sd, np.std([0.2, 0.3], ddof=1), rtol=1e-3)
    assert np.isnan(gait.across([]).double_stance.mean)


def test_spread_leaves_out_what_is_no_number() -> None:
    assert gait.spread(np.array([1.0, np.nan, 3.0, np.inf])) == (2.0, np.sqrt(2.0), 2)
    mean, sd, num = gait.spread(np.array([5.0]))
    assert (mean, num) == (5.0, 1) and np.isnan(sd)


@pytest.mark.slow
def test_the_spatial_body_has_footfalls_too() -> None:
    env = Flame()
    start = env.reset(env.sample_trials(jax.random.key(0), 1).given(0))
    states = jax.tree.map(lambda leaf: np.asarray(leaf)[None, None].repeat(3, 0), start)
    made = Recording(np.array([[0.0], [0.01], [0.02]], np.float32), states.trial.done, states)
    (footfalls,) = find_footfalls(made, observe(made, env))
    assert not footfalls.contact[:, 0].any() and footfalls.contact[:, 1].all()
    assert not footfalls.left_stance.any()
