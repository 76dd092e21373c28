"""Tests of winners that are recorded, on a planar walker that has hardly evolved."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from report.outline import Outline

from mjxwalk.cli import main
from mjxwalk.report import recorded, sources


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of two generations."""
    path = tmp_path_factory.mktemp("recorded") / "run"
    flags = ["--generations", "2", "--population", "16", "--seed", "1", "--out", str(path)]
    assert main(["evolve", "planar-lpd", *flags]) == 0
    return path


@pytest.mark.slow
def test_the_gait_is_told_beside_a_humans(run: Path) -> None:
    assert main(["report", str(run), "--trials", "3"]) == 0
    table = pd.read_csv(run / "report" / "table-5.csv", index_col="variant")
    assert table.loc["planar-lpd", "trials"] == 3
    assert table.loc["human", "double_stance"] == 0.204
    outline = Outline((run / "report" / "report.html").read_text())
    assert not outline.unbalanced
    labels = [svg.attributes["aria-label"] for svg in outline.named("svg")]
    assert any("stick figure" in label for label in labels)


@pytest.mark.slow
def test_without_trials_nothing_is_recorded(run: Path) -> None:
    assert main(["report", str(run), "--trials", "0", "--out", str(run / "page")]) == 0
    assert not (run / "page" / "table-5.csv").exists()
    assert "--trials 100 makes them" in Outline((run / "page" / "report.html").read_text()).text


@pytest.mark.slow
def test_recorded_twice_is_the_same_and_every_trial_is_counted_once(run: Path) -> None:
    variants = sources.by_variant([sources.read(run)])
    first, second = (
        recorded.record(variants, num_trials=53, seed=2, engine="auto", say=lambda text: None)
        for _ in range(2)
    )
    one, two = first["planar-lpd"], second["planar-lpd"]
    assert one.gaits[0].trials == 53
    np.testing.assert_array_equal(one.density.counts, two.density.counts)
    np.testing.assert_array_equal(one.stick.sticks.skeletons, two.stick.sticks.skeletons)
    # The first figure stands where trials begin: its hips are at one place, above the ankles.
    left, right = one.stick.sticks.skeletons[0]
    np.testing.assert_array_equal(left[1], right[1])
    assert left[1, 0] == pytest.approx(0.0, abs=1e-6)
    assert left[1, 2] > left[4, 2]
