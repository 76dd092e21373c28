"""Tests of where a body's joints are in stick figures, by the sizes in its file."""

import numpy as np

from mjxwalk.analysis.sticks import skeleton
from mjxwalk.envs import Flame, Planar7, Reil


def test_skeleton_of_a_body_that_stands_straight_is_a_column() -> None:
    qpos = np.zeros((2, 9))
    qpos[:, 1] = 0.9275
    figures = skeleton(Planar7(), qpos)
    assert figures.shape == (2, 2, 8, 3)
    np.testing.assert_allclose(figures[..., 1], 0.0, atol=1e-12)
    np.testing.assert_allclose(figures[:, :, :5, 0], 0.0, atol=1e-12)
    # papers: thigh 0.429 m, shank 0.4305 m, ankle 0.068 m over the sole
    np.testing.assert_allclose(figures[0, 0, 1:5, 2], [0.9275, 0.9275, 0.4985, 0.068], atol=1e-9)
    np.testing.assert_allclose(figures[0, 0, 5:7, 2], 0.0, atol=1e-9)


def test_skeleton_of_a_spatial_body_that_stands_straight_is_two_columns() -> None:
    qpos = np.zeros((1, 15))
    qpos[:, 2] = 0.646
    (figure,) = skeleton(Flame(), qpos)
    # flame.xml: thigh 0.3155 m, shank 0.2915 m, hip 0.646 m high and 0.083 m beside the middle,
    # shank 14 mm inward; the foot reaches from 0.047 m behind to 0.153 m ahead of the ankle.
    np.testing.assert_allclose(figure[:, 2:6, 2], [[0.646, 0.646, 0.3305, 0.039]] * 2, atol=1e-9)
    np.testing.assert_allclose(figure[:, 3:6, 1], [[0.083, 0.069, 0.069], [-0.083, -0.069, -0.069]])
    np.testing.assert_allclose(figure[:, 6:8, 0], [[-0.047, 0.153]] * 2, atol=1e-9)
    np.testing.assert_allclose(figure[:, 6:8, 2], 0.0, atol=1e-9)


def test_skeleton_of_a_hip_powered_body_stands_on_its_spheres_lowest_points() -> None:
    qpos = np.zeros((1, 14))
    qpos[:, 2] = 1.16
    (figure,) = skeleton(Reil(), qpos)
    # reil.xml: thigh 0.5 m, calf 0.54 m; spheres of 0.08 m, 0.04 m below the ankle; the trunk's
    # centre is 0.3 m over the hips, which are 0.125 m beside the middle.
    heights = [1.76, 1.16, 1.16, 1.16, 0.66, 0.12, 0.0, 0.0, 0.12]
    np.testing.assert_allclose(figure[..., 2], [heights] * 2, atol=1e-9)
    np.testing.assert_allclose(figure[:, 2:, 1], [[0.125] * 7, [-0.125] * 7], atol=1e-9)
    np.testing.assert_allclose(figure[:, 6:8, 0], [[-0.079, -0.029]] * 2, atol=1e-9)
