"""Tests of the planar terrain."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs import RandomWalk, Terrain
from mjxwalk.envs.bodies.planar7_body import LEG_LENGTH

WALK = RandomWalk()


def terrain(heights: jax.Array, row: int = 0) -> Terrain:
    return Terrain(heights, jnp.asarray(row, jnp.int32))


def test_heights_over_a_step_spread_by_5_4_percent_of_leg_length() -> None:
    heights = np.asarray(WALK.sample(jax.random.key(0), 400))[:, 30:]
    # Steps of 0.6 and 0.7 m, between which a walker of this size lands.
    spread = [np.std(heights[:, lag:] - heights[:, :-lag]) for lag in (6, 7)]
    np.testing.assert_allclose(np.mean(spread) / LEG_LENGTH, 0.054, atol=0.002)


def test_spread_over_a_step_is_that_of_independent_steps() -> None:
    heights = np.asarray(RandomWalk(roughness=0.01).sample(jax.random.key(1), 400))[:, 30:]
    spread = np.std(heights[:, 9:] - heights[:, :-9])
    np.testing.assert_allclose(spread, 0.01 * 3.0, rtol=0.02)  # sqrt(9); 4e5 samples, correlated


def test_ground_is_flat_up_to_the_toes_and_rough_at_once_after() -> None:
    heights = np.asarray(WALK.sample(jax.random.key(2), 50))
    x = WALK.start + WALK.spacing * np.arange(WALK.num_nodes)
    flat = x < WALK.flat_until + 1e-6
    assert np.all(heights[:, flat] == 0.0)
    first = heights[:, np.argmin(flat)]
    np.testing.assert_allclose(np.abs(first), WALK.roughness, rtol=1e-6)
    assert 0 < np.sum(first > 0) < 50


def test_height_interpolates_and_ends_go_on_level() -> None:
    heights = WALK.sample(jax.random.key(3), 2)
    x = np.array([-50.0, -2.0, 0.45, 7.77, 55.555, 100.3, 500.0], np.float32)
    nodes = WALK.start + WALK.spacing * np.arange(WALK.num_nodes)
    ours = [WALK.height(terrain(heights, 1), jnp.asarray(value)) for value in x]
    # float32 x of 55 m lies within 4e-6 m, on slopes of 0.2.
    np.testing.assert_allclose(ours, np.interp(x, nodes, heights[1]), atol=1e-5)


def test_height_at_nan_is_not_an_invalid_read() -> None:
    height = WALK.height(terrain(jnp.ones((1, WALK.num_nodes))), jnp.asarray(jnp.nan))
    assert jnp.isnan(height) or height == 1.0


def test_same_key_same_terrain_other_key_another() -> None:
    one, same, other = (WALK.sample(jax.random.key(seed), 3) for seed in (4, 4, 5))
    np.testing.assert_array_equal(one, same)
    assert not np.array_equal(one, other)
    assert not np.array_equal(one[0], one[1])


def test_negative_roughness_is_refused() -> None:
    with pytest.raises(ValueError, match="roughness must be 0 or above, got -0.1"):
        RandomWalk(roughness=-0.1)
