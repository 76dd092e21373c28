"""Tests of the ground that is shown around walkers, against the ground that they walk on."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs import (
    Flame,
    Planar7,
    RandomWalk,
    Reil,
    SerpentineWalk,
    TrialVariation,
    scenery,
)
from mjxwalk.envs.scenery import AHEAD, BEHIND, BESIDE, Scenery
from mjxwalk.envs.terrain import Patch


def test_a_height_lies_on_the_lines_between_nodes() -> None:
    heights = np.array([[0.0, 1.0, 4.0], [10.0, 11.0, 14.0]])
    shown = Scenery(Patch(x=1.0, y=-0.5, spacing=0.5, heights=heights), width=0.5)
    assert shown.height(1.5, -0.5) == 1.0
    assert shown.height(1.75, -0.5) == 2.5
    assert shown.height(1.75, 0.0) == 12.5
    assert shown.height(1.75, -0.25) == 7.5
    # The ends go on level.
    assert shown.height(-9.0, -9.0) == 0.0 and shown.height(9.0, 9.0) == 14.0


ROUGH: dict[str, Any] = {
    "plane": Planar7(terrain=RandomWalk(roughness=0.02, length=30.0)),
    "space": Flame(terrain=SerpentineWalk(roughness=0.01, length=12.0, width=4.0)),
}


@pytest.mark.parametrize("kind", ROUGH)
def test_the_shown_ground_is_the_one_that_is_walked_on(kind: str) -> None:
    env = ROUGH[kind]
    trial = env.sample_trials(jax.random.key(3), 2).given(jnp.int32(1))
    qpos = np.zeros((2, 3, len(env.anatomy.coordinates)))
    qpos[1, 2, 0] = 5.0
    if kind == "space":
        qpos[1, 0, 1] = 0.8
    shown = scenery.around(env, trial.ground, qpos)
    patch = shown.patch
    assert patch.x <= -BEHIND and patch.x + patch.spacing * patch.heights.shape[1] > 5.0 + AHEAD
    for x in (-2.5, 0.0, 1.03, 2.3, 4.99):
        for y in (0.0, 0.31, -0.47):
            truth = env.terrain.height(trial.ground, jnp.asarray(x), jnp.asarray(y))
            # float32 places of some metres on slopes of a fifth
            assert shown.height(x, y) == pytest.approx(float(truth), abs=1e-5)


def test_ground_without_rows_is_as_wide_as_walkers_drift() -> None:
    env = Reil(terrain=TrialVariation(slope=0.1))
    trials = env.terrain.drawn(jnp.array([[0.0, 0.0, 0.0, 0.0, 0.0, -0.5]]))
    qpos = np.zeros((2, 1, 14))
    qpos[1, 0, :2] = 20.0, 4.0
    shown = scenery.around(env, trials.given(0).ground, qpos)
    assert shown.width == pytest.approx(2 * (4.0 + BESIDE))
    assert shown.height(20.0, 4.0) == pytest.approx(-1.0)
