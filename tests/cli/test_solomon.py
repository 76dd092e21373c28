"""The published study from the command line, small: physics, engine and tournament as they are."""

import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mjxwalk import runs, tournament, walkers
from mjxwalk.controllers.linear_reactive import local_links
from mjxwalk.runs import inheritance


@pytest.mark.slow
def test_a_small_study_goes_through_every_phase_in_two_minutes(tmp_path: Path) -> None:
    path = tmp_path / "study"
    command = [sys.executable, "-m", "mjxwalk", "evolve", "solomon-2d", "--scale", "0.02"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([*command, "--out", str(path)], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    # Of a core: what else the machine does meanwhile would count in the time of day.
    assert after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime < 120

    phases = [path / name for name in ("1-walk", "2-rough", "3-steady", "4-lpd", "5-fil", "6-sil")]
    # The walker that comes first reaches a goal, and of the next two populations the mean goes on.
    assert [tournament.read(phase) for phase in phases[:3]] == [None, None, None]
    phases = phases[3:]
    for phase in phases:
        held = tournament.read(phase)
        assert held is not None
        assert held.conditions[0].trials == 20 and held.roughness_m == 0.02
        assert walkers.best(phase).rank == "winner"
    lpd, fil, sil = (runs.load(phase) for phase in phases)

    # LPD has local links alone, and FIL all.
    others = ~local_links()
    assert not lpd.population["walking"][:, others].any()
    assert fil.population["walking"][:, others].all()
    given = inheritance.read(phases[1]).genotype["walking"]
    assert not given[others].any()
    np.testing.assert_array_equal(given, walkers.best(phases[0]).genotype.walking)

    # SIL has pruned links, of both sets of weights at once, and none that is local. So few walkers
    # may have got all of them back from each other by the end.
    assert np.nanmax(sil.metrics["strategy.num_pruned"]) > 0
    gone = sil.population["walking"] == 0.0
    assert not gone[:, local_links()].any()
    np.testing.assert_array_equal(gone, sil.population["initiation"] == 0.0)
    assert sil.strategy_state["finished"] or sil.generation == 60


@pytest.mark.slow
def test_a_small_spatial_study_goes_from_slight_to_rough_ground(tmp_path: Path) -> None:
    path = tmp_path / "study"
    command = [sys.executable, "-m", "mjxwalk", "evolve", "solomon-3d-rough", "--scale", "0.01"]
    # The goal's first phase would go on until one walks.
    settings = ["--set", "slight.goal.trials=0", "--set", "rough.env.max_time=2"]
    subprocess.run([*command, *settings, "--out", str(path)], check=True, capture_output=True)
    slight, rough = runs.load(path / "1-slight"), runs.load(path / "2-rough")
    assert (slight.generation, rough.generation) == (20, 3)
    assert slight.population["links"].shape == (10, 7, 26)
    given = inheritance.read(path / "2-rough").genotype["links"]
    np.testing.assert_array_equal(given, walkers.best(path / "1-slight").genotype.links)
    held = tournament.read(path / "2-rough")
    assert held is not None and held.roughness_m == 0.02
    assert [each.name for each in held.conditions] == [
        "as evolved",
        "half the time step",
        "perturbed starts",
    ]
