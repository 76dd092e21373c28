"""Tests of the ground in space."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs import SerpentineWalk, Terrain
from mjxwalk.envs.bodies.flame_body import LEG_LENGTH
from mjxwalk.envs.surface import serpentine

UNIT = SerpentineWalk(roughness=1.0)
SMALL = SerpentineWalk(length=12.0, width=2.0)


@functools.cache
def sample(walk: SerpentineWalk, seed: int, num: int) -> np.ndarray:
    return np.asarray(jax.jit(walk.sample, static_argnums=1)(jax.random.key(seed), num))


def surface(heights: np.ndarray, row: int = 0) -> Terrain:
    return Terrain(jnp.asarray(heights), jnp.asarray(row, jnp.int32))


def height(walk: SerpentineWalk, ground: Terrain, x: float, y: float) -> float:
    return float(walk.height(ground, jnp.asarray(x), jnp.asarray(y)))


@pytest.mark.parametrize(("roughness", "percent"), [(0.002, 0.36), (0.01, 2.0), (0.02, 3.55)])
def test_heights_over_a_step_spread_as_in_the_paper(roughness: float, percent: float) -> None:
    heights = sample(UNIT, 0, 64)[:, 50:] * roughness
    # Steps of 0.6 and 0.7 m along x, between which a walker of this size lands.
    spread = np.mean([np.std(heights[:, lag:] - heights[:, :-lag]) for lag in (6, 7)])
    # Heights are proportional to r; the paper's own three figures are so only within 11 %.
    np.testing.assert_allclose(100 * spread / LEG_LENGTH, percent, rtol=0.11)
    across = np.mean([np.std(heights[..., lag:] - heights[..., :-lag]) for lag in (6, 7)])
    np.testing.assert_allclose(across, spread, rtol=0.03)  # the two layers cancel any bias


def by_hand(key: np.random.Generator, rows: int, columns: int) -> np.ndarray:
    """Fills a grid cell by cell, as Appendix A tells it."""
    grid = np.zeros((rows, columns), int)
    grid[0] = np.cumsum(key.choice([-1, 1], columns))
    for i in range(1, rows):
        path = range(columns) if i % 2 == 0 else range(columns - 1, -1, -1)
        before: int | None = None
        for j in path:
            above = grid[i - 1, j]
            if before is None:
                grid[i, j] = above + key.choice([-1, 1])
            elif before == above:
                grid[i, j] = before + key.choice([-1, 1])
            else:
                assert abs(before - above) == 2
                grid[i, j] = before - np.sign(before - above)
            before = int(grid[i, j])
    return grid


def test_serpentines_spread_like_a_grid_filled_cell_by_cell() -> None:
    key = np.random.default_rng(0)
    slow = np.stack([by_hand(key, 12, 9) for _ in range(1500)])
    fast = np.asarray(serpentine(jax.random.key(1), 1500, 12, 9)).astype(int)
    for grid in (slow, fast):
        assert np.all(np.abs(np.diff(grid, axis=1)) == 1)
        assert np.all(np.abs(np.diff(grid, axis=2)) == 1)
    # Every cell's distance from the first row's start and from the last cell: 1,500 samples give
    # variances to 3.7 % (one standard error); of 216, the worst lies within five.
    for corner in ((slice(None), 0, 0), (slice(None), -1, -1)):
        one, other = ((g - g[corner][:, None, None]).var(axis=0) + 1.0 for g in (slow, fast))
        np.testing.assert_allclose(one, other, rtol=0.25)


def test_the_first_two_metres_are_flat_and_what_follows_is_not() -> None:
    heights = sample(UNIT, 0, 64)
    x = UNIT.start + UNIT.spacing * np.arange(UNIT.num_nodes[0])
    flat = x < 2.0 + 1e-6
    assert np.all(heights[:, flat] == 0.0)
    assert np.all(heights[:, np.argmin(flat)].std(axis=1) > 0.0)
    # No cliff where it begins: a box of five nodes spreads the step over as many.
    assert np.abs(heights[:, np.argmin(flat)]).max() < 3.0


def test_height_interpolates_between_nodes() -> None:
    heights = sample(SMALL, 2, 3)
    ground = surface(heights, 1)
    nodes_x = SMALL.start + 0.1 * np.arange(120)
    nodes_y = -0.95 + 0.1 * np.arange(20)
    np.testing.assert_allclose(
        height(SMALL, ground, nodes_x[77], nodes_y[13]), heights[1, 77, 13], atol=1e-8
    )
    x, y = nodes_x[77] + 0.03, nodes_y[13] + 0.08
    rows = 0.7 * heights[1, 77] + 0.3 * heights[1, 78]
    wanted = 0.2 * rows[13] + 0.8 * rows[14]
    np.testing.assert_allclose(height(SMALL, ground, x, y), wanted, atol=1e-7)


def test_beyond_its_sides_the_ground_goes_on_mirrored_and_beyond_its_ends_level() -> None:
    ground = surface(sample(SMALL, 2, 3))
    edge = 0.95
    for way in (0.03, 0.4, 1.7):
        inside = height(SMALL, ground, 5.03, edge - way)
        np.testing.assert_allclose(height(SMALL, ground, 5.03, edge + way), inside, atol=1e-7)
        again = height(SMALL, ground, 5.03, edge - way - 4 * edge)
        np.testing.assert_allclose(again, inside, atol=1e-7)
    last = height(SMALL, ground, 9.9, 0.3)
    assert height(SMALL, ground, 500.0, 0.3) == pytest.approx(last, abs=1e-7)
    assert height(SMALL, ground, -50.0, 0.3) == 0.0


def test_height_at_nan_is_not_an_invalid_read() -> None:
    ground = surface(np.ones((1, 120, 20), np.float32))
    for x, y in ((np.nan, 0.0), (0.0, np.nan), (np.inf, np.inf)):
        value = height(SMALL, ground, x, y)
        assert np.isnan(value) or value == 1.0


def test_same_key_same_ground_other_key_another() -> None:
    one, other = sample(SMALL, 4, 3), sample(SMALL, 5, 3)
    again = np.asarray(SMALL.sample(jax.random.key(4), 3))
    np.testing.assert_allclose(one, again, rtol=1e-6)  # fused or not, sums round differently
    assert not np.array_equal(one, other) and not np.array_equal(one[0], one[1])


def test_wrong_settings_are_refused() -> None:
    with pytest.raises(ValueError, match="roughness must be 0 or above, got -0.1"):
        SerpentineWalk(roughness=-0.1)
    with pytest.raises(ValueError, match="width must hold two nodes, got 0.1 m"):
        SerpentineWalk(width=0.1)
