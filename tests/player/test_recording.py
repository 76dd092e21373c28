"""Tests of what a page is told about walkers."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import toy
from player.given import PLANAR, SPATIAL, made, recorded, shown

from mjxwalk.analysis.strides import debounced
from mjxwalk.errors import RunError
from mjxwalk.player import packing, recording
from mjxwalk.player.recording import Take


def test_series_are_the_recording_and_frames_end_with_the_trial() -> None:
    show, text = made(PLANAR)
    series = packing.unpack(show.series, text)
    recording_, felt, _ = recorded(PLANAR, 50.0, 3.0)
    walker = show.walkers[0]
    assert walker.frames == 151 and show.frame_s == pytest.approx(0.02)
    moves = recording_.states.qpos[:, 0].T
    np.testing.assert_allclose(series["walker 0 moves"], moves, atol=recording.MOVE_STEP)
    torques = felt.torque.T
    np.testing.assert_allclose(series["walker 0 torques"], torques, atol=recording.TORQUE_STEP)
    assert walker.ending == "open" and walker.figures.duration_s == pytest.approx(3.0)
    assert walker.figures.distance_m == pytest.approx(moves[0, -1])
    assert show.what == "winner of the tournament, generation 56"
    # Loads and contacts tell the same story.
    loaded = series["walker 0 pushes"].reshape(4, 3, -1)[:, 2].T.reshape(-1, 2, 2).sum(axis=2) > 0
    touching = recording_.states.touching[:, 0].reshape(-1, 2, 2).any(axis=2)
    seconds = recording_.time[:, 0].astype(np.float64)
    alike = debounced(loaded, seconds, 0.05) == debounced(touching, seconds, 0.05)
    assert alike.mean() > 0.97  # a point may touch and yet not be pushed


def test_walkers_that_fall_end_where_they_fell_and_say_why() -> None:
    given = shown(PLANAR)
    still = jax.tree.map(np.zeros_like, given.genotypes)
    both: Any = jax.tree.map(lambda a, b: np.concatenate([a, b]), given.genotypes, still)
    several = dataclasses.replace(given, genotypes=both, labels=("walks", "falls"))
    show, text = recording.perform(several, Take(seconds=2.0))
    walks, falls = show.walkers
    assert walks.ending == "open" and falls.ending == "fall"
    assert falls.frames < walks.frames and falls.why.startswith("fell: ")
    moves = packing.unpack(show.series, text)["walker 1 moves"]
    assert moves.shape == (9, falls.frames)
    assert abs(moves[:, -1] - moves[:, -2]).max() > 0.001  # not a frame that repeats the end


def test_the_ground_of_the_page_is_the_ground_that_is_walked_on() -> None:
    given = shown(PLANAR)
    show, text = made(PLANAR)
    row = packing.unpack(show.series, text)["heights"][0]
    terrain = given.experiment.sample_trials(jax.random.key(0), 1).given(jnp.int32(0)).ground
    for x in (-2.5, 0.0, 1.0, 2.3, 4.0):
        ours = np.interp(x, show.ground.x + show.ground.spacing * np.arange(len(row)), row)
        truth = float(given.experiment.env.terrain.height(terrain, jnp.asarray(x)))
        assert ours == pytest.approx(truth, abs=recording.HEIGHT_STEP)


@pytest.mark.slow
def test_ground_in_space_reaches_to_the_sides_of_the_way() -> None:
    given = shown(SPATIAL)
    show, text = made(SPATIAL)
    rows = packing.unpack(show.series, text)["heights"]
    assert rows.shape[0] == show.ground.rows
    terrain = given.experiment.sample_trials(jax.random.key(0), 1).given(jnp.int32(0)).ground
    surface = given.experiment.env.terrain
    for node, row in ((40, 1), (60, 7), (70, show.ground.rows - 1)):
        x = show.ground.x + node * show.ground.spacing
        y = show.ground.y + row * show.ground.spacing
        truth = float(surface.height(terrain, jnp.asarray(x), jnp.asarray(y)))
        assert rows[row, node] == pytest.approx(truth, abs=2 * recording.HEIGHT_STEP)


def test_a_body_that_is_not_known_is_refused() -> None:
    given = dataclasses.replace(shown(PLANAR), experiment=toy.Toy())
    with pytest.raises(RunError, match="a World has no anatomy to show; see how its runs went"):
        recording.perform(given, Take(seconds=1.0))
