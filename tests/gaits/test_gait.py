"""The adults' gait against what is published of it, and Fourier series against their definition."""

import dataclasses

import numpy as np
import pytest

from mjxwalk import gaits

PHASE = 2 * np.pi * np.arange(gaits.NUM_POINTS) / gaits.NUM_POINTS


def test_the_adults_knee_bends_most_in_swing_as_published():
    knee = gaits.adults().knee
    # Comfortable speed, same subjects: 61.7 degrees with a deviation of 4.0 between them.
    assert 61.7 - 4.0 < knee.max() < 61.7 + 4.0
    assert 60 < knee.argmax() < 80


def test_the_adults_hip_is_flexed_at_heel_strike_and_extended_before_toe_off():
    hip = gaits.adults().hip
    assert hip[0] > 25
    assert hip.min() < -5
    assert 45 < hip.argmin() < 60


def test_the_right_leg_is_half_a_cycle_off():
    gait = gaits.adults()
    joints = gait.four_joints
    np.testing.assert_array_equal(joints[:50, 1], gait.hip[50:])
    np.testing.assert_array_equal(joints[50:, 3], gait.knee[:50])


def test_harmonics_are_those_that_a_curve_was_made_of():
    curve = 10 + 3 * np.cos(PHASE) - 2 * np.sin(PHASE) + 5 * np.sin(2 * PHASE)
    series = gaits.harmonics(curve, 3)
    assert series.mean == pytest.approx(10)
    np.testing.assert_allclose(series.cosine, [3, 0, 0], atol=1e-12)
    np.testing.assert_allclose(series.sine, [-2, 5, 0], atol=1e-12)
    # 3 cos x - 2 sin x = A cos(x + f)
    again = series.amplitude[0] * np.cos(PHASE + series.phase[0])
    np.testing.assert_allclose(again, 3 * np.cos(PHASE) - 2 * np.sin(PHASE), atol=1e-12)


def test_a_series_and_its_derivative_are_evaluated():
    series = gaits.Harmonics(1.0, np.array([2.0, 0.0]), np.array([0.0, 3.0]))
    at = np.array([0.0, 0.3])
    expected = 1 + 2 * np.cos(at) + 3 * np.sin(2 * at)
    np.testing.assert_allclose(gaits.evaluate(series, at), expected)
    slope = -2 * np.sin(at) + 6 * np.cos(2 * at)
    np.testing.assert_allclose(gaits.evaluate(series, at, derivative=1), slope)


def test_three_harmonics_leave_a_degree_of_the_knee():
    knee = gaits.adults().knee
    off = [knee - gaits.evaluate(gaits.harmonics(knee, num), PHASE) for num in (1, 3)]
    rms = [float(np.sqrt(np.mean(each**2))) for each in off]
    # The bound on what one oscillator a knee can do.
    assert rms[0] > 12
    assert rms[1] < 1.5


def test_wrong_numbers_are_refused():
    with pytest.raises(ValueError, match="num must be from 1 to 49, got 50"):
        gaits.harmonics(gaits.adults().knee, 50)
    # The annotations, which tests check, refuse it before the settings do.
    with pytest.raises(Exception, match="hip"):
        dataclasses.replace(gaits.adults(), hip=np.zeros(3))
    with pytest.raises(ValueError, match="stride_time must be positive, got 0"):
        dataclasses.replace(gaits.adults(), stride_time=0.0)
