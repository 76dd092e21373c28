"""The published study from the command line, small: physics, engine and tournament as they are."""

import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mjxwalk import runs, tournament, walkers
from mjxwalk.controllers.linear_reactive import local_links
from mjxwalk.runs import start


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
    given = start.read(phases[1]).genotype["walking"]
    assert not given[others].any()
    np.testing.assert_array_equal(given, walkers.best(phases[0]).genotype.walking)

    # SIL has pruned links, of both sets of weights at once, and none that is local. So few walkers
    # may have got all of them back from each other by the end.
    assert np.nanmax(sil.metrics["strategy.num_pruned"]) > 0
    gone = sil.population["walking"] == 0.0
    assert not gone[:, local_links()].any()
    np.testing.assert_array_equal(gone, sil.population["initiation"] == 0.0)
    assert sil.strategy_state["finished"] or sil.generation == 60
