"""Tests of which runs are averaged, and which are refused."""

import dataclasses
from pathlib import Path

import pytest
from report.made import changed, phase

from mjxwalk.envs import Flame
from mjxwalk.errors import RunError
from mjxwalk.report import sources
from mjxwalk.report.sources import Phase, Source


def source(*phases: Phase) -> Source:
    return Source(path=phases[0].run.path.parent, study=None, phases=phases)


def test_phases_of_studies_are_joined_by_name_in_the_order_of_the_longest() -> None:
    reduced = source(
        phase("lpd", study="solomon-2d-rsil", seed=5), phase("rsil", study="solomon-2d-rsil")
    )
    whole = source(phase("lpd"), phase("fil"), phase("sil"))
    variants = sources.by_variant([reduced, whole])
    assert list(variants) == ["lpd", "fil", "sil", "rsil"]
    assert [each.seed for each in variants["lpd"]] == [5, 0]


def test_runs_of_other_settings_are_refused_by_the_first_that_differs() -> None:
    other = changed(phase("fil", seed=1), population_size=40)
    with pytest.raises(RunError, match=r"fil-0 and .*fil-1 .*population_size is 150 .* and 40"):
        sources.by_variant([source(phase("fil")), source(other)])


def test_settings_inside_of_settings_are_compared() -> None:
    first = phase("fil")
    env = dataclasses.replace(first.experiment.env, torso_mass=40.0)
    with pytest.raises(RunError, match=r"env.torso_mass is 47.46 in the one and 40.0"):
        sources.by_variant([source(first), source(changed(phase("fil", seed=1), env=env))])


@pytest.mark.usefixtures("unchecked_types")
def test_runs_of_other_bodies_are_refused() -> None:
    spatial = changed(phase("fil", seed=1), env=Flame())
    with pytest.raises(
        RunError, match=r"body Planar7 and .*fil-1 with Flame; report on them apart"
    ):
        sources.by_variant([source(phase("fil")), source(spatial)])


def test_runs_that_are_no_phases_need_one_experiment() -> None:
    lone = dataclasses.replace(
        changed(phase("fil", seed=1), name="planar-fil"), name="planar-fil", study=None
    )
    assert list(sources.by_variant([source(lone), source(lone)])) == ["planar-fil"]
    with pytest.raises(RunError, match=r"experiment solomon-2d/fil and .* of planar-fil"):
        sources.by_variant([source(phase("fil")), source(lone)])


def test_bytes_that_are_no_text_are_shown() -> None:
    assert sources.shown(Path("runs/\udcff")) == r"runs/\udcff"
