"""The page on a fit: the thesis beside ours by one measure, and pages that would mix two things."""

from pathlib import Path

import pandas as pd
import pytest

from mjxwalk import cli

FEW = ("--generations", "4", "--population", "12", "--set", "strategy.breeding_generations=3")


def _evolve(folder: Path, experiment: str, seed: int = 0) -> Path:
    made = ["evolve", experiment, *FEW, "--set", "cycles=2", "--seed", str(seed)]
    assert cli.main([*made, "--out", str(folder)]) == 0
    return folder


@pytest.mark.slow
def test_the_page_has_the_figures_the_tables_and_the_thesis_numbers(tmp_path: Path):
    run = _evolve(tmp_path / "run", "rayleigh")
    other = _evolve(tmp_path / "other", "rayleigh", seed=1)
    assert cli.main(["report", str(run), str(other), "--out", str(tmp_path / "page")]) == 0
    html = (tmp_path / "page" / "report.html").read_text()
    for caption in ("Table 1", "Figure 5.1", "Figures 5.2 to 5.5", "Figure 5.6", "Figures 2.4"):
        assert caption in html
    table = pd.read_csv(tmp_path / "page" / "table-1.csv").set_index("parameter")
    assert table.loc["k34", "thesis"] == pytest.approx(0.3012)
    errors = pd.read_csv(tmp_path / "page" / "errors.csv").set_index("joint")
    assert 12 < errors.loc["left knee", "thesis' Table 1 by the human's clock"] < 13
    assert 12 < errors.loc["left knee", "best single sine"] < 13


@pytest.mark.slow
def test_two_kinds_of_fits_are_not_put_on_one_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    runs = [_evolve(tmp_path / name, name) for name in ("rayleigh", "rayleigh-harmonic")]
    assert cli.main(["report", *map(str, runs), "--out", str(tmp_path / "page")]) != 0
    assert "report on them apart" in capsys.readouterr().err
