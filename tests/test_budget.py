"""Tests of what is measured before memory is taken, and of the doors that ask for it."""

import types
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
from toy import Toy

from mjxwalk import budget, experiments, replay
from mjxwalk.envs import RandomWalk, SerpentineWalk, TrialVariation
from mjxwalk.errors import RunError
from mjxwalk.evolution import memory
from mjxwalk.video import filming

GIGABYTE = 1_000_000_000


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Makes believe that this process may have a gigabyte."""
    monkeypatch.setattr(budget, "available", lambda: GIGABYTE)


def test_what_fits_passes_and_one_byte_more_is_refused(small: None) -> None:
    budget.check(GIGABYTE, "it takes", "ask for less")
    with pytest.raises(RunError, match="^it takes 1 GB, and this process may have 1 GB of memory"):
        budget.check(GIGABYTE + 1, "it takes", "ask for less")


@pytest.mark.parametrize(
    ("terrain", "fits"),
    [
        (RandomWalk(length=100.0), 83_333),  # a thousand nodes of four bytes, three times
        (SerpentineWalk(length=10.0, width=1.0), 83_333),
        (TrialVariation(), 83_333_333),
        (None, 83_333_333),
    ],
)
def test_grounds_are_counted_by_their_nodes(small: None, terrain: object, fits: int) -> None:
    env = types.SimpleNamespace(terrain=terrain)
    budget.check_grounds(env, fits)
    with pytest.raises(RunError, match=f"{fits + 1:,} terrains take 1 GB"):
        budget.check_grounds(env, fits + 1)


def test_no_terrain_is_drawn_that_does_not_fit(small: None) -> None:
    experiment = experiments.get("planar-lpd")
    assert experiment.sample_trials(jax.random.key(0), 3).heights.shape == (3, 1024)
    with pytest.raises(RunError, match="terrains take .* GB"):
        experiment.sample_trials(jax.random.key(0), 10**30)


def test_a_generations_walkers_are_counted_with_a_copy_for_each_terrain(small: None) -> None:
    genotype = {"weights": np.zeros(242, np.float32)}  # and 32 bytes of outcome make 1,000
    memory.check_trials(genotype, 1_000, 1_000)
    with pytest.raises(RunError, match="1,000 walkers on 1,001 terrains each take 1 GB"):
        memory.check_trials(genotype, 1_000, 1_001)


def test_a_toy_of_the_least_settings_is_measured(small: None) -> None:
    memory.check_settings(Toy())


def test_frames_that_do_not_fit_are_not_recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    experiment: Any = experiments.get("planar-lpd")
    trial = experiment.env.level_trials().given(np.zeros(1, np.int32))
    walkers = jax.tree.map(lambda leaf: np.asarray(leaf)[None], experiment.template())

    def record() -> replay.Recording:
        return replay.record(experiment.env, experiment.controller, walkers, trial, duration=1.0)

    whole = record()
    assert len(whole.time) > 20
    monkeypatch.setattr(budget, "available", lambda: 1_000)
    with pytest.raises(RunError, match="1 recorded trials take .* record fewer trials"):
        record()


def test_no_walker_is_tried_more_often_than_anybody_waits() -> None:
    budget.check_asked("--trials", budget.MOST_TRIALS)
    with pytest.raises(RunError, match="--trials must be at most 1,000,000, got 1,000,001"):
        budget.check_asked("--trials", budget.MOST_TRIALS + 1)


def test_a_gif_that_does_not_fit_is_not_kept(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    picture = np.zeros((10, 20, 3), np.uint8)
    monkeypatch.setattr(budget, "available", lambda: 1_000)  # two of these, twice
    write = filming._write_gif  # pyright: ignore[reportPrivateUsage]
    write(tmp_path / "a.gif", iter([picture] * 2), 25.0, (20, 10))
    with pytest.raises(RunError, match="3 pictures of a gif take .* film fewer seconds"):
        write(tmp_path / "b.gif", iter([picture] * 3), 25.0, (20, 10))
