"""Tests that the anatomy of each body that ships is what C MuJoCo shows of its file."""

import dataclasses
import functools
from typing import Any

import numpy as np
import pytest

from mjxwalk import robots
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mjcf import reader
from mjxwalk.envs.mjcf_env import MjcfEnv

# Hip, knee and ankle of the left leg, and of each the sign of the angle that moves what is below it
# backward, as the makers' files say it.
LEGS = {
    "h1": (("left_hip_pitch", 1), ("left_knee", 1), ("left_ankle", 1)),
    "g1": (("left_hip_pitch_joint", 1), ("left_knee_joint", 1), ("left_ankle_pitch_joint", 1)),
    "t1": (("Left_Hip_Pitch", 1), ("Left_Knee_Pitch", 1), ("Left_Ankle_Pitch", 1)),
    "apollo": (("l_hip_fe", 1), ("l_knee_fe", 1), ("l_ankle_pd", 1)),
    "op3": (("l_hip_pitch", 1), ("l_knee", 1), ("l_ank_pitch", -1)),
    "berkeley_humanoid": (("LL_HFE_left", 1), ("LL_KFE_left", 1), ("LL_FFE_left", 1)),
    "humanoid": (("hip_pitch_left", 1), ("knee_left", -1), None),
    "walker2d": (("hip_left", -1), ("knee_left", -1), ("ankle_left", -1)),
    "flame": (("hip_left", -1), ("knee_left", 1), ("ankle_left", -1)),
    "planar7": (("hip_left", -1), ("knee_left", 1), ("ankle_left", -1)),
}
# Where each foot touches the ground.
POINTS = {"h1": 3, "op3": 8, "humanoid": 3, "walker2d": 2, "planar7": 2}
BENT = 0.3  # rad; knees of those that ship a `home`, but for Walker2d, bend at least so far


@functools.cache
def env_of(name: str) -> MjcfEnv:
    """Returns the environment of a body that ships."""
    return MjcfEnv.of(reader.read(robots.path(name)).text)


def moved(env: MjcfEnv, qpos: Any) -> Any:
    """Returns the data of the engines' tree in C MuJoCo."""
    data = mujoco.MjData(env.model.mujoco)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(env.model.mujoco, data)
    mujoco.mj_comPos(env.model.mujoco, data)  # of subtree_com
    return data


def mirrored(env: MjcfEnv, qpos: Any) -> Any:
    """Returns the coordinates after left and right have changed places."""
    coordinates = env.anatomy.coordinates
    partners = [each.mirror for each in coordinates]
    return np.array([each.sign for each in coordinates]) * qpos[partners]


def drawn(env: MjcfEnv, seed: int) -> Any:
    """Returns coordinates within the joints' ranges, m and rad."""
    draw = np.random.default_rng(seed)
    ends = np.array([(each.lower, each.upper) for each in env.anatomy.coordinates])
    return draw.uniform(*np.clip(ends, -1.0, 1.0).T)


@pytest.mark.parametrize("name", robots.names())
def test_both_legs_have_the_hips_knees_and_ankles_of_the_file(name: str) -> None:
    anatomy = env_of(name).anatomy
    left, right = anatomy.legs
    assert (left.side, right.side) == ("left", "right")
    for role, joint in zip(("hip", "knee", "ankle"), LEGS[name], strict=True):
        place, other = getattr(left, role), getattr(right, role)
        if joint is None:
            assert place is None and other is None
            continue
        assert anatomy.coordinates[place].name == joint[0]
        assert anatomy.coordinates[place].mirror == other
        assert anatomy.coordinates[other].mirror == place


@pytest.mark.parametrize("name", robots.names())
def test_joints_of_a_leg_turn_as_the_file_says(name: str) -> None:
    env = env_of(name)
    start = np.array(env.reset(env.level_trials().given(0)).qpos)
    standing = moved(env, start)
    for joint, backward in filter(None, LEGS[name]):
        place = env.anatomy.place(joint)
        bent = start.copy()
        bent[place] += 0.01 * backward
        before, after = (
            points_of(env, data, 0).mean(axis=0) for data in (standing, moved(env, bent))
        )
        below = standing.xanchor[place][2] - before[2]
        assert below > -1e-6
        # Turned about y, what is below moves backward by the angle times its depth.
        assert before[0] - after[0] == pytest.approx(0.01 * below, rel=0.1, abs=1e-5), joint


@pytest.mark.parametrize("name", robots.names())
def test_a_mirrored_pose_has_mirrored_places(name: str) -> None:
    env, over = env_of(name), np.array([1.0, -1.0, 1.0])
    for seed in range(3):
        qpos = drawn(env, seed)
        data, other = moved(env, qpos), moved(env, mirrored(env, qpos))
        for joint, coordinate in enumerate(env.anatomy.coordinates):
            if coordinate.mirror == joint:  # the makers set some a little to one side
                continue
            expected = data.xanchor[joint] * over
            assert other.xanchor[coordinate.mirror] == pytest.approx(expected, abs=1e-5), coordinate
        for leg in (0, 1):
            expected = points_of(env, data, leg) * over
            assert points_of(env, other, 1 - leg) == pytest.approx(expected, abs=1e-4)


def points_of(env: MjcfEnv, data: Any, leg: int) -> Any:
    """Returns where a leg's contact points are, m [point, axis], hind and inner ones first."""
    anatomy, over = env.anatomy, (1.0, -1.0)[leg]
    points = [anatomy.points[place] for place in anatomy.points_of(anatomy.legs[leg])]
    stance = moved(env, env.reset(env.level_trials().given(0)).qpos)

    def order(point: Any) -> tuple[float, float]:
        x, y, _ = stance.site(point.name).xpos
        return round(float(x), 3), round(float(over * y), 3)

    return np.array([data.site(point.name).xpos for point in sorted(points, key=order)])


@pytest.mark.parametrize("name", robots.names())
def test_feet_touch_the_ground_around_the_centre_of_mass(name: str) -> None:
    env = env_of(name)
    anatomy = env.anatomy
    state = env.reset(env.level_trials().given(0))
    data = moved(env, state.qpos)
    assert state.touching.all()
    places = np.array([data.site(point.name).xpos for point in anatomy.points])
    heights = places[:, 2] - [point.radius for point in anatomy.points]
    assert heights == pytest.approx(np.zeros(len(heights)), abs=5e-3)
    for axis in (0,) if anatomy.root.is_planar else (0, 1):
        assert places[:, axis].min() < data.subtree_com[0][axis] < places[:, axis].max()


@pytest.mark.parametrize("name", robots.names())
def test_feet_are_long_and_have_few_points(name: str) -> None:
    env = env_of(name)
    for number, leg in enumerate(env.anatomy.legs):
        data = moved(env, env.reset(env.level_trials().given(0)).qpos)
        points = points_of(env, data, number)
        assert len(points) == POINTS.get(name, 4)
        length = np.ptp(points[:, 0])
        assert length > 0.1 * env.leg_length
        heel, toe = env.anatomy.heel_and_toe(leg)
        turn = data.body(leg.foot).xmat.reshape(3, 3)
        assert (turn @ (toe - heel))[0] == pytest.approx(length, rel=0.15)


@pytest.mark.parametrize(
    "name", [each for each in robots.names() if each not in ("planar7", "flame")]
)
def test_the_start_is_home_with_knees_bent(name: str) -> None:
    env = env_of(name)
    model = mujoco.MjModel.from_xml_path(str(robots.path(name)))
    home = model.key("home").qpos
    start = np.array(env.reset(env.level_trials().given(0)).qpos)
    joints = [joint for joint in range(model.njnt) if model.jnt_bodyid[joint] != 1]
    assert start[env.anatomy.root.num :] == pytest.approx(home[model.jnt_qposadr[joints]], abs=1e-6)
    for leg in env.anatomy.legs:
        assert abs(start[leg.knee]) > (0.15 if name == "walker2d" else BENT)


# flame's file has no actuators; the reader gives it some.
@pytest.mark.parametrize("name", [each for each in robots.names() if each != "flame"])
def test_motors_have_the_limits_and_gains_of_the_file(name: str) -> None:
    env = dataclasses.replace(env_of(name), gains="file")
    model = mujoco.MjModel.from_xml_path(str(robots.path(name)))
    assert len(env.anatomy.motors) == model.nu
    root = env.anatomy.root.num
    first = model.njnt - (len(env.anatomy.coordinates) - root)
    for motor in env.anatomy.motors:
        joint = motor.coordinate - root + first
        (actuator,) = np.flatnonzero(model.actuator_trnid[:, 0] == joint)
        kind = model.actuator(actuator)
        if kind.biasprm.any():
            assert motor.stiffness == pytest.approx(kind.gainprm[0])
            assert motor.damping == pytest.approx(-kind.biasprm[2])
            limits = np.array([-np.inf, np.inf])
        else:
            limits = kind.gear[0] * kind.ctrlrange if kind.ctrllimited else [-np.inf, np.inf]
        if kind.forcelimited:
            limits = kind.forcerange
        if model.jnt_actfrclimited[joint]:
            limits = model.jnt_actfrcrange[joint]
        assert (motor.lowest, motor.highest) == pytest.approx(tuple(limits))


@pytest.mark.parametrize("name", robots.names())
def test_a_body_weighs_what_its_file_says(name: str) -> None:
    env = env_of(name)
    model = mujoco.MjModel.from_xml_path(str(robots.path(name)))
    assert env.weight == pytest.approx(9.81 * model.body_mass.sum(), rel=1e-5)
