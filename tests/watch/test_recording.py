"""Tests of what a page is told about walkers, and of the forces on them."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import toy
from watch.given import PLANAR, SPATIAL, cast, made

from mjxwalk import replay
from mjxwalk.analysis.strides import debounced
from mjxwalk.envs import Terrain
from mjxwalk.errors import RunError
from mjxwalk.watch import forces, grounds, packing, recording
from mjxwalk.watch.recording import Take


def together(source: str, frames_per_second: float, seconds: float) -> Any:
    given = cast(source)
    experiment = given.experiment
    heights = np.asarray(experiment.sample_trials(jax.random.key(0), 1))
    terrain: Any = Terrain(heights, np.zeros(1, np.int32))  # type: ignore[arg-type]
    recorded = replay.record(
        experiment.env,
        experiment.controller,
        given.genotypes,
        terrain,
        duration=seconds,
        frames_per_second=frames_per_second,
    )
    genotype = jax.tree.map(lambda leaf: leaf[0], given.genotypes)
    env, controller = experiment.env, experiment.controller
    return recorded, forces.measure(env, controller, genotype, terrain, recorded, 0), experiment


@pytest.mark.parametrize(
    "source", [PLANAR, pytest.param(SPATIAL, marks=pytest.mark.slow)], ids=["planar", "spatial"]
)
def test_the_ground_carries_the_body_and_changes_its_momentum(source: str) -> None:
    recorded, felt, experiment = together(source, 1000.0, 4.0)
    steady = recorded.time[:, 0] > 1.0
    upward = felt.ground[steady, :, 2].sum(axis=1)
    # Over whole strides a body's momentum is as before, so the ground gave its weight back. What
    # is left is the last stride's part.
    assert upward.mean() == pytest.approx(experiment.weight, rel=0.04)
    # No point is pulled down, and one in the air feels nothing; a step later its contact is told.
    assert (felt.ground[..., 2] >= 0).all()
    in_air = ~recorded.states.touching[1:, 0]
    pushed = felt.ground[:-1][in_air].any(axis=1)
    assert in_air.sum() > 1000 and pushed.mean() < 0.002  # a depth of nothing may be rounded up
    # Coulomb's law.
    along = np.linalg.norm(felt.ground[..., :2], axis=-1)
    assert (along <= experiment.env.contact.friction * felt.ground[..., 2] * 1.001 + 1e-3).all()


def test_torques_are_what_the_trial_counts_as_cost() -> None:
    recorded, felt, experiment = together(PLANAR, 1000.0, 1.0)
    counted = np.diff(recorded.states.torque_cost[:, 0].astype(np.float64))
    ours = np.abs(felt.torque[:-1]).sum(axis=1) * experiment.env.timestep
    # The cost is summed in float32, a ten-thousandth of a unit at a time.
    np.testing.assert_allclose(ours, counted, atol=2e-3, rtol=0.02)


def test_series_are_the_recording_and_frames_end_with_the_trial() -> None:
    show, text = made(PLANAR)
    series = packing.unpack(show.series, text)
    recorded, felt, _ = together(PLANAR, 50.0, 3.0)
    walker = show.walkers[0]
    assert walker.frames == 151 and show.frame_s == pytest.approx(0.02)
    moves = recorded.states.qpos[:, 0].T
    np.testing.assert_allclose(series["walker 0 moves"], moves, atol=recording.MOVE_STEP)
    torques = felt.torque.T
    np.testing.assert_allclose(series["walker 0 torques"], torques, atol=recording.TORQUE_STEP)
    assert walker.ending == "open" and walker.figures.duration_s == pytest.approx(3.0)
    assert walker.figures.distance_m == pytest.approx(moves[0, -1])
    assert show.what == "winner of the tournament, generation 56"
    # Loads and contacts tell the same story.
    loaded = series["walker 0 pushes"].reshape(4, 3, -1)[:, 2].T.reshape(-1, 2, 2).sum(axis=2) > 0
    touching = recorded.states.touching[:, 0].reshape(-1, 2, 2).any(axis=2)
    seconds = recorded.time[:, 0].astype(np.float64)
    alike = debounced(loaded, seconds, 0.05) == debounced(touching, seconds, 0.05)
    assert alike.mean() > 0.97  # a point may touch and yet not be pushed


def test_walkers_that_fall_end_where_they_fell_and_say_why() -> None:
    given = cast(PLANAR)
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
    given = cast(PLANAR)
    show, text = made(PLANAR)
    row = packing.unpack(show.series, text)["heights"][0]
    heights = np.asarray(given.experiment.sample_trials(jax.random.key(0), 1))
    terrain = Terrain(jnp.asarray(heights), jnp.int32(0))
    for x in (-2.5, 0.0, 1.0, 2.3, 4.0):
        ours = np.interp(x, show.ground.x + show.ground.spacing * np.arange(len(row)), row)
        truth = float(given.experiment.env.terrain.height(terrain, jnp.asarray(x)))
        assert ours == pytest.approx(truth, abs=recording.HEIGHT_STEP)


@pytest.mark.slow
def test_ground_in_space_reaches_to_the_sides_of_the_way() -> None:
    given = cast(SPATIAL)
    show, text = made(SPATIAL)
    rows = packing.unpack(show.series, text)["heights"]
    assert rows.shape[0] == show.ground.rows
    heights = np.asarray(given.experiment.sample_trials(jax.random.key(0), 1))
    terrain = Terrain(jnp.asarray(heights), jnp.int32(0))
    surface = given.experiment.env.terrain
    for node, row in ((40, 1), (60, 7), (70, show.ground.rows - 1)):
        x = show.ground.x + node * show.ground.spacing
        y = show.ground.y + row * show.ground.spacing
        truth = float(surface.height(terrain, jnp.asarray(x), jnp.asarray(y)))
        assert rows[row, node] == pytest.approx(truth, abs=2 * recording.HEIGHT_STEP)
        # Between nodes too.
        below = surface.height(terrain, jnp.asarray(x + 0.03), jnp.asarray(y - 0.04))
        ours = grounds.height(show.ground, rows, [x + 0.03, y - 0.04])
        assert ours == pytest.approx(float(below), abs=2 * recording.HEIGHT_STEP)


def test_a_body_that_is_not_known_is_refused() -> None:
    given = dataclasses.replace(cast(PLANAR), experiment=toy.Toy())
    with pytest.raises(RunError, match="a World cannot be shown; Planar7, Flame and Reil can"):
        recording.perform(given, Take(seconds=1.0))
