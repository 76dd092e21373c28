"""Tests of the figures of trials against hand-worked cases."""

import numpy as np
import pytest

from mjxwalk.outcomes import cost_of_transport, over_terrains, speed


def test_a_mean_with_nan_is_nan() -> None:
    means = over_terrains(np.array([[1.0, 2.0], [np.nan, 2.0]], np.float32))
    np.testing.assert_array_equal(means, np.array([1.5, np.nan], np.float32))


def test_speed_and_cost_by_hand() -> None:
    assert speed(np.array([3.0, 1.0]), np.array([2.0, 2.0])) == 1.0
    assert speed(np.zeros(2), np.zeros(2)) is None
    assert cost_of_transport(np.array([50.0, 30.0]), np.array([3.0, 1.0]), 10.0) == 2.0


@pytest.mark.parametrize("distance", [0.0, -1.0, np.nan])
def test_no_transport_has_no_cost(distance: float) -> None:
    assert cost_of_transport(np.array([50.0]), np.array([distance]), 10.0) is None
