"""Tests of what the page is told about bodies."""

import msgspec
import numpy as np
import pytest

from mjxwalk.envs import Flame, LeggedEnv, Planar7, Reil
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.player import bodies
from mjxwalk.player.bodies import Body, Link

BODIES = pytest.mark.parametrize(
    "env", [Planar7(), Flame(), Reil()], ids=["planar", "spatial", "hips"]
)


def turned(quat: tuple[float, ...]) -> np.ndarray:
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, np.array(quat))
    return matrix.reshape(3, 3)


def place(body: Body, coordinates: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Returns position and axes of every link, as the page works them out."""
    found: list[tuple[np.ndarray, np.ndarray]] = []
    for link in body.links:
        origin, axes = np.zeros(3), np.eye(3)
        if link.parent >= 0:
            origin, axes = found[link.parent]
        origin, axes = origin + axes @ np.array(link.pos), axes @ turned(link.quat)
        found.append(_moved(link, origin, axes, coordinates))
    return found


def _moved(
    link: Link, origin: np.ndarray, axes: np.ndarray, coordinates: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    for joint in link.joints:
        axis, value = np.array(joint.axis), coordinates[joint.coordinate]
        if joint.move == "slide":
            origin = origin + axes @ axis * value
        else:
            quat = np.concatenate([[np.cos(value / 2)], np.sin(value / 2) * axis])
            axes = axes @ turned(tuple(quat))
    return origin, axes


@BODIES
def test_links_and_shapes_are_where_mujoco_has_them(env: LeggedEnv) -> None:
    body, anatomy = bodies.describe(env), env.anatomy
    coordinates = np.random.default_rng(0).uniform(-0.7, 0.7, len(anatomy.coordinates))
    model = env.model.mujoco
    data = mujoco.MjData(model)
    data.qpos[:] = coordinates[list(anatomy.joint_coordinate)]
    mujoco.mj_kinematics(model, data)
    links = place(body, coordinates)
    for index, (origin, axes) in enumerate(links):
        # Numbers of the page have six places.
        np.testing.assert_allclose(origin, data.xpos[index + 1], atol=1e-5)
        np.testing.assert_allclose(axes.ravel(), data.xmat[index + 1], atol=1e-5)
    geoms = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] > 0]
    assert len(geoms) == len(body.parts)
    for geom, part in zip(geoms, body.parts, strict=True):
        origin, axes = links[part.body]
        centre = origin + axes @ np.array(part.pos)
        np.testing.assert_allclose(centre, data.geom_xpos[geom], atol=1e-5)
    for known, point in zip(anatomy.points, body.points, strict=True):
        origin, axes = links[point.body]
        truth = data.site(known.name).xpos
        # Feet of the planar body are drawn apart, across the plane that it moves in.
        np.testing.assert_allclose(
            (origin + axes @ np.array(point.pos))[[0, 2]], truth[[0, 2]], atol=1e-5
        )


@BODIES
def test_every_joint_is_plotted_once_and_motors_are_an_actions(env: LeggedEnv) -> None:
    body = bodies.describe(env)
    coordinates = [angle.coordinate for angle in body.angles]
    assert len(set(coordinates)) == len(coordinates)
    motors = sorted(angle.motor for angle in body.angles if angle.motor is not None)
    assert motors == list(range(len(env.anatomy.motors)))
    names = {angle.name for angle in body.angles}
    assert {"hip", "knee", "ankle"} <= names
    assert ("adduction" in names) == isinstance(env, Flame)


@BODIES
def test_sticks_run_along_the_shapes(env: LeggedEnv) -> None:
    body = bodies.describe(env)
    assert {stick.side for stick in body.sticks} == {"left", "right", "middle"}
    feet = [stick for stick in body.sticks if len(stick.line) == 4]
    assert len(feet) == 2
    for foot in feet:
        ankle, heel, toe, again = foot.line
        assert ankle == again and heel[0] < 0 and heel[0] < toe[0]


@BODIES
def test_what_the_page_is_told_reads_back(env: LeggedEnv) -> None:
    body = bodies.describe(env)
    assert msgspec.json.decode(msgspec.json.encode(body), type=Body) == body


def test_the_planar_foot_has_a_surface() -> None:
    (foot, _) = [part for part in bodies.describe(Planar7()).parts if part.shape == "mesh"]
    corners = np.array(foot.vertices).reshape(-1, 3)
    assert len(corners) == 8 and max(foot.faces) == 7
    # planar7.xml: 0.196 m from the ankle to the toe and 0.07 m to the heel
    # in whatever order MuJoCo has put the axes
    assert np.ptp(corners, axis=0).max() == pytest.approx(0.266, abs=0.02)


def test_a_foot_of_spheres_is_drawn_as_they_are() -> None:
    body = bodies.describe(Reil())
    assert {part.shape for part in body.parts} == {"box", "sphere"} and len(body.parts) == 11
    assert [point.side for point in body.points] == ["left", "left", "right", "right"]
    lines = [point for stick in body.sticks for point in stick.line]
    assert np.isfinite(lines).all()
    driven = [angle.name for angle in body.angles if angle.motor is not None]
    assert driven == ["hip", "hip"]
