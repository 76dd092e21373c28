"""Tests of anatomies: by hand for our bodies, and against MuJoCo's kinematics."""

import re
from typing import Any

import numpy as np
import pytest

from mjxwalk.envs import Anatomy, Flame, LeggedEnv, Planar7, Reil
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.anatomy import Leg

PLANAR, SPATIAL, HIPS = Planar7(), Flame(), Reil()
ENVS: dict[str, LeggedEnv] = {"planar": PLANAR, "spatial": SPATIAL, "hips": HIPS}
every_body = pytest.mark.parametrize("name", ENVS)
# Of each body, the place that takes each coordinate's value as left and right change places; and
# which values change their sign: y, yaw and roll.
MIRRORS: dict[str, list[int]] = {
    "planar": [0, 1, 2, 6, 7, 8, 3, 4, 5],
    "spatial": [*range(7), 11, 12, 13, 14, 7, 8, 9, 10],
    "hips": [*range(6), 10, 11, 12, 13, 6, 7, 8, 9],
}
TURNED: dict[str, list[int]] = {"planar": [], "spatial": [1, 3, 5], "hips": [1, 3, 5]}


@every_body
def test_mirror_partners_and_signs_are_those_worked_out_by_hand(name: str) -> None:
    coordinates = ENVS[name].anatomy.coordinates
    assert [each.mirror for each in coordinates] == MIRRORS[name]
    signs = np.ones(len(coordinates))
    signs[TURNED[name]] = -1.0
    assert [each.sign for each in coordinates] == signs.tolist()


@every_body
def test_mirrored_coordinates_put_the_mirrored_points_into_their_places(name: str) -> None:
    env = ENVS[name]
    anatomy = env.anatomy
    qpos = np.random.default_rng(0).uniform(-0.6, 0.6, len(anatomy.coordinates))
    partner = np.array([each.mirror for each in anatomy.coordinates])
    mirrored = np.array([each.sign for each in anatomy.coordinates]) * qpos[partner]
    one, other = points(env, qpos), points(env, mirrored)
    for point, place in one.items():
        side = "left" if point.endswith("left") else "right"
        twin = point.replace(side, "right" if side == "left" else "left")
        np.testing.assert_allclose(other[twin], place * [1.0, -1.0, 1.0], atol=1e-12)


def points(env: LeggedEnv, qpos: Any) -> dict[str, Any]:
    """Returns where the contact points are in the world, m, by C MuJoCo."""
    model, anatomy = env.model.mujoco, env.anatomy
    data = mujoco.MjData(model)
    data.qpos[:] = qpos[list(anatomy.joint_coordinate)]
    mujoco.mj_kinematics(model, data)
    return {each.name: data.site(each.name).xpos.copy() for each in anatomy.points}


def test_the_adduction_that_both_legs_share_is_one_coordinate_of_two_joints() -> None:
    anatomy = SPATIAL.anatomy
    tied = np.insert(np.eye(15), 11, np.eye(15)[6], axis=0)
    np.testing.assert_array_equal(anatomy.coupling, tied)
    assert anatomy.joint_coordinate == (*range(11), 6, *range(11, 15))
    np.testing.assert_array_equal(anatomy.first_joint, [*range(11), *range(12, 16)])
    adduction = anatomy.coordinates[anatomy.place("adduction")]
    assert (adduction.side, adduction.mirror, adduction.sign) == ("middle", 6, 1.0)
    for other in (PLANAR, HIPS):
        assert other.anatomy.coupling is None


def test_the_roots_coordinates_are_told_by_their_axes() -> None:
    assert PLANAR.anatomy.root._asdict() == {
        "num": 3, "forward": 0, "sideways": None, "height": 1, "yaw": None, "pitch": 2, "roll": None
    }  # fmt: skip
    assert PLANAR.anatomy.root.is_planar and PLANAR.anatomy.root.num_slides == 2
    for env in (SPATIAL, HIPS):
        root = env.anatomy.root
        assert tuple(root) == (6, 0, 1, 2, 3, 4, 5)
        assert not root.is_planar and root.num_slides == 3


@pytest.mark.parametrize(
    ("env", "first"), [(PLANAR, (3, 6)), (SPATIAL, (7, 11)), (HIPS, (7, 11))], ids=list(ENVS)
)
def test_legs_have_hip_knee_and_ankle(env: LeggedEnv, first: tuple[int, int]) -> None:
    left, right = (
        Leg(side, f"foot_{side}", hip, hip + 1, hip + 2)
        for side, hip in zip(("left", "right"), first, strict=True)
    )
    assert env.anatomy.legs == (left, right)
    half = len(env.anatomy.points) // 2
    assert env.anatomy.points_of(left) == list(range(half))
    assert env.anatomy.points_of(right) == list(range(half, 2 * half))


@pytest.mark.parametrize(
    ("env", "heel", "toe"),
    [
        (PLANAR, (-0.07, 0.0, -0.068), (0.196, 0.0, -0.068)),
        (SPATIAL, (-0.047, 0.0, -0.039), (0.153, 0.0, -0.039)),  # of each, the middle of two
        (HIPS, (-0.079, 0.0, -0.04), (-0.029, 0.0, -0.04)),
    ],
    ids=list(ENVS),
)
def test_heel_and_toe_are_the_ends_of_the_sole(env: LeggedEnv, heel: Any, toe: Any) -> None:
    for leg in env.anatomy.legs:
        found = env.anatomy.heel_and_toe(leg)
        np.testing.assert_allclose(found, [heel, toe], atol=1e-12)


def test_a_foot_of_one_point_is_heel_and_toe_at_once() -> None:
    anatomy = PLANAR.anatomy
    toes = tuple(each for each in anatomy.points if each.name.startswith("toe"))
    heel, toe = anatomy._replace(points=toes).heel_and_toe(anatomy.legs[0])
    np.testing.assert_array_equal(heel, toe)
    np.testing.assert_array_equal(toe, [0.196, 0.0, -0.068])


def test_ranges_are_the_files_or_the_settings_and_of_others_without_end() -> None:
    knee = PLANAR.anatomy.coordinates[4]
    np.testing.assert_allclose([knee.lower, knee.upper], np.radians([0.0, 131.8]))
    root = PLANAR.anatomy.coordinates[0]
    assert (root.lower, root.upper, root.unit) == (-np.inf, np.inf, "m")
    knee = Reil(knee_extension=-0.2, knee_flexion=1.5).anatomy.coordinates[8]
    assert (knee.name, knee.lower, knee.upper, knee.unit) == ("knee_left", -0.2, 1.5, "rad")


def test_motors_say_what_they_drive_and_how_strong_they_are() -> None:
    names = [f"{joint}_{leg}" for leg in ("left", "right") for joint in ("hip", "knee", "ankle")]
    assert [each.name for each in PLANAR.anatomy.motors] == names
    assert PLANAR.anatomy.driven.tolist() == [3, 4, 5, 6, 7, 8]
    assert SPATIAL.anatomy.driven.tolist() == [6, 7, 8, 9, 11, 12, 13]
    assert HIPS.anatomy.driven.tolist() == [7, 11]
    for env, law, limit in ((PLANAR, "torque", np.inf), (HIPS, "velocity", HIPS.hips.max_torque)):
        for each in env.anatomy.motors:
            assert (each.law, each.lowest, each.highest) == (law, -limit, limit)


@every_body
def test_senses_are_the_fields_of_what_is_observed(name: str) -> None:
    env = ENVS[name]
    seen = env.observe(env.reset(env.level_trials().given(0)))._asdict()
    there = {field: leaf for field, leaf in seen.items() if leaf is not None}
    assert [each.name for each in env.anatomy.senses] == list(there)
    for each in env.anatomy.senses:
        assert len(each.order) in (0, there[each.name].size)


def test_coordinates_are_found_and_shown_by_name() -> None:
    anatomy: Anatomy = SPATIAL.anatomy
    place = anatomy.place("ankle_roll_right")
    assert place == 14 and anatomy.coordinates[place].words == "ankle roll"
    assert anatomy.coordinates[place].side == "right"
    with pytest.raises(ValueError, match=re.escape("Flame has no elbow; it has root_x, root_y")):
        anatomy.place("elbow")
