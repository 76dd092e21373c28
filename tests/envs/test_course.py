"""Tests of what lies along the way: heights by hand, and what walkers and pictures see of it."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs import (
    Course,
    Flame,
    Gaps,
    Planar7,
    RandomWalk,
    Reil,
    SerpentineWalk,
    Slope,
    Stairs,
    Stretches,
    Terrain,
    scenery,
)

STAIRS = Course(stairs=Stairs(rise=0.1, begin=1.0, number=3))
GAPS = Course(gaps=Gaps(width=0.2, depth=0.4, spread=0.0))
SLOPE = Course(slope=Slope(gradient=-0.1), length=10.0)
SOIL = Course(soft=Stretches(factor=0.5, spread=0.0), slippery=Stretches(factor=0.2, begin=50.0))


def lying(course: Course, x: float) -> Any:
    """Returns what the first course lays at a place."""
    table = course.sample(jax.random.key(0), 1)
    ground = Terrain(jnp.zeros((1, 2)), jnp.int32(0), table)
    return jax.tree.map(float, course.under(ground, jnp.float32(x)))


@pytest.mark.parametrize(
    ("course", "heights"),
    [
        # A step rises behind its edge, over a cell of 0.05 m.
        (STAIRS, {-3: 0, 1: 0, 1.025: 0.05, 1.05: 0.1, 1.3: 0.1, 1.35: 0.2, 1.65: 0.3, 200: 0.3}),
        # The pieces are 2 m long from x = 2 m on, and the gaps in their middles.
        (GAPS, {2: 0, 2.9: 0, 2.95: -0.4, 3.05: -0.4, 3.1: 0, 4: 0, 5: -0.4, 90.925: -0.2}),
        # The last node is at 9.95 m; beyond, it goes on level.
        (SLOPE, {0: 0, 2: 0, 3: -0.1, 9.95: -0.795, 20: -0.795}),
        (SOIL, {2: 0, 3.5: 0, 80: 0}),
    ],
    ids=["stairs", "gaps", "slope", "soil"],
)
def test_heights_are_those_that_a_hand_works_out(
    course: Course, heights: dict[float, float]
) -> None:
    for x, height in heights.items():
        assert lying(course, x).height == pytest.approx(height, abs=2e-5), x  # float32 at 90 m


def test_gradients_are_those_of_the_cells() -> None:
    assert lying(STAIRS, 1.02).gradient == pytest.approx(2.0, rel=1e-4)
    assert lying(STAIRS, 1.2).gradient == lying(STAIRS, -1.0).gradient == 0.0
    assert lying(SLOPE, 5.02).gradient == pytest.approx(-0.1, rel=1e-4)
    assert lying(SLOPE, 11.0).gradient == 0.0
    assert lying(SOIL, 3.5).gradient is None


def test_soil_differs_in_stretches_alone() -> None:
    # The pieces are 3 m long from x = 2 m on; 1 m in the middle of each is soft.
    assert lying(SOIL, 3.5).footing == (0.5, 1.0)
    assert lying(SOIL, 2.5).footing == (1.0, 1.0)
    assert lying(SLOPE, 3.0).footing is None


def test_parts_add_up() -> None:
    both = Course(stairs=STAIRS.stairs, slope=SLOPE.slope, soft=SOIL.soft)
    at = lying(both, 3.5)
    assert at.height == pytest.approx(0.3 - 0.15, abs=1e-5)
    assert at.footing.stiffness == 0.5


DRAWN = Course(
    slope=Slope(spread=0.1),
    stairs=Stairs(rise=0.05, spread=0.02, begin=20.0),
    gaps=Gaps(width=0.3, begin=40.0),
    slippery=Stretches(factor=0.5),
)


def test_trials_draw_what_has_a_spread_each_for_itself() -> None:
    table = np.asarray(DRAWN.sample(jax.random.key(3), 500))
    gradient = table[:, 200, 0] / 8.0  # at 10 m, 8 m from its begin
    assert gradient.min() == pytest.approx(-0.1, abs=0.003)
    assert gradient.max() == pytest.approx(0.1, abs=0.003)
    assert abs(gradient.mean()) < 0.01
    risen = table[:, 620, 0] - gradient * 29.0  # at 31 m, behind all of the ten steps
    assert risen.min() == pytest.approx(0.3, abs=0.01)
    assert risen.max() == pytest.approx(0.7, abs=0.01)
    slope = gradient[:, None] * (0.05 * np.arange(2048) - 2.0)
    deep = table[:, :, 0] - slope - risen[:, None] < -0.25
    first = np.argmax(deep[:, 800:840], axis=1)  # the first piece, from 40 to 42 m
    assert set(deep[:, 800:840].sum(axis=1)) == {5}  # nodes between edges that are 6 cells apart
    # In the middle, 1 m on, the gap's first node is the 18th; a spread of 0.5 m are ten more.
    assert first.min() == 8 and first.max() == 28
    again = np.asarray(DRAWN.sample(jax.random.key(3), 500))
    np.testing.assert_array_equal(again, table)


def test_the_random_ground_does_not_know_of_the_course() -> None:
    for env in (Planar7(), Flame(), Reil()):
        key = jax.random.key(2)
        plain = env.sample_trials(key, 3)
        other = dataclasses.replace(env, course=STAIRS).sample_trials(key, 3)
        np.testing.assert_array_equal(other.heights, plain.heights)
        assert plain.course is None and other.course is not None
        assert other.course.shape == (3, 2048, 1)
        assert env.level_trials().course is None


def test_a_course_is_told_in_words() -> None:
    assert Course().words() == ""
    assert SLOPE.words() == "slope -10 %"
    expected = "slope -10 to 10 %, steps 30 to 70 mm, gaps 300 mm, friction 0.5 in stretches"
    assert DRAWN.words() == expected
    assert SOIL.words() == "stiffness 0.5 in stretches, friction 0.2 in stretches"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"spacing": 0.2, "stairs": Stairs(rise=0.1)}, "the tread of Stairs must be two spacings"),
        ({"gaps": Gaps(width=0.07)}, "the width of Gaps must be two spacings, 0.1 m, at least"),
        ({"length": 0.05}, "length must hold two nodes"),
        ({"spacing": 1e-6}, "length must hold at most"),
    ],
)
def test_what_nodes_cannot_hold_is_refused(settings: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Course(**settings)


def test_neighbours_that_could_meet_are_refused() -> None:
    with pytest.raises(ValueError, match="every must be width and twice the spread at least, 2.2"):
        Gaps(width=1.2)
    with pytest.raises(ValueError, match="every must be width and twice the spread at least, 4 m"):
        Stretches(width=2.0)


def test_a_course_of_another_shape_is_refused() -> None:
    env = Planar7(course=SLOPE)
    given = env.sample_trials(jax.random.key(0), 2).given(0)
    assert given.ground.course is not None
    for course in (given.ground.course[:1], given.ground.course[:, :-1], given.ground.heights):
        wrong = given._replace(ground=given.ground._replace(course=course))
        with pytest.raises(ValueError, match=r"course must have shape \(2, 200, 1\), got"):
            env.reset(wrong)


@pytest.mark.parametrize(
    "env",
    [
        Planar7(terrain=RandomWalk(roughness=0.01, length=20.0), course=DRAWN),
        Flame(terrain=SerpentineWalk(roughness=0.01, length=12.0, width=4.0), course=DRAWN),
        Reil(course=DRAWN),
    ],
    ids=["plane", "space", "no nodes"],
)
def test_the_shown_ground_is_the_one_that_is_walked_on(env: Any) -> None:
    given = env.sample_trials(jax.random.key(3), 2).given(jnp.int32(1))
    qpos = np.zeros((2, 1, len(env.anatomy.coordinates)))
    qpos[1, 0, 0] = 43.0
    shown = scenery.around(env, given.ground, qpos)
    for x in (-2.5, 0.0, 1.03, 4.99, 20.03, 21.2, 40.6, 40.85, 41.0, 41.1, 41.26, 42.0):
        truth = env.ground_height(given, jnp.float32(x), jnp.float32(0.31))
        # float32 places of 40 m on edges that rise by 6 m a metre
        assert shown.height(x, 0.31) == pytest.approx(float(truth), abs=1e-4)
