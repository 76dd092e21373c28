"""Tests of the contact points that are taken of a foot's geoms."""

import numpy as np
import pytest

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.derived import points as mjcf_points
from mjxwalk.envs.derived.source import Pose

SHANK = '<geom type="capsule" size="0.04" fromto="0 0 {end}  0 0 0.4"/>'


def points(foot: str, shank: str = "", planar: bool = False) -> list[list[float]]:
    """Returns the places of a foot's contact points, m, in its axes, in order of their numbers.

    Args:
      foot: its geoms.
      shank: geoms of the body that carries it and counts as foot too.
      planar: whether it moves in the plane.
    """
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody><body><freejoint/>{shank}<body>{foot}</body></body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    found = mjcf_points.of_foot(Pose(model, data), [2, 1], planar=planar, reach=1.0)
    return sorted([float(value) for value in each.offset] for each in found)


def test_a_box_touches_with_its_lower_corners() -> None:
    found = points('<geom type="box" size="0.1 0.05 0.01"/>')
    assert found == [[x, y, -0.01] for x in (-0.1, 0.1) for y in (-0.05, 0.05)]


def test_points_between_others_are_left_out() -> None:
    capsules = ("-0.1 0 0  0 0 0", "0 0 0  0.1 0.05 0", "0 0 0.005  0.1 -0.05 0")
    foot = "".join(f'<geom type="capsule" size="0.01" fromto="{ends}"/>' for ends in capsules)
    assert np.array(points(foot)) == pytest.approx(
        np.array([[-0.1, 0, 0], [0.1, -0.05, 0], [0.1, 0.05, 0]]), abs=1e-9
    )


def test_an_arched_sole_touches_with_its_ends() -> None:
    foot = "".join(
        f'<geom type="sphere" size="0.01" pos="{x} 0 {z}"/>'
        for x, z in ((-0.1, 0), (0, 0.02), (0.1, 0))
    )
    assert points(foot, planar=True) == [[-0.1, 0, 0], [0.1, 0, 0]]


def test_a_round_sole_touches_with_all_its_spheres() -> None:
    foot = "".join(
        f'<geom type="sphere" size="0.01" pos="{x} 0 {z}"/>'
        for x, z in ((-0.1, 0.02), (0, 0), (0.1, 0.02))
    )
    assert len(points(foot, planar=True)) == 3


def test_a_shank_that_ends_inside_the_foot_does_not_touch() -> None:
    foot = '<geom type="capsule" size="0.06" fromto="0 0 0.1  0.2 0 0.1"/>'
    assert len(points(foot, SHANK.format(end=0.1))) == 2
    assert len(points(foot, SHANK.format(end=0.05))) == 3


def test_a_turned_foot_has_the_points_of_a_straight_one() -> None:
    boxes = (
        '<geom type="box" size="0.1 0.05 0.01" pos="0 0 0.05"/>',
        '<geom type="box" size="0.08 0.05 0.01" pos="0 0 0.06" euler="0 0 90"/>',
    )
    assert len(points(boxes[0])) == 4
    assert len(points(boxes[0] + boxes[1])) == 8
