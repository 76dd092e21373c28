"""Tests of `mjxwalk evolve --strategy`."""

from pathlib import Path

import pytest
import toy

from mjxwalk import experiments, runs
from mjxwalk.cli import main


@pytest.fixture(autouse=True)
def in_new_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)


def test_another_strategy_keeps_the_settings_that_it_takes_and_resumes() -> None:
    asked = "--strategy sep-cma-es --generations 3 --population 8 --seed 1"
    assert main(["evolve", "toy", *asked.split(), "--out", "a"]) == 0
    run = runs.load("a")
    experiment = experiments.of_run(run)
    assert experiment.strategy.name == "sep-cma-es"
    assert experiment.strategy.options == {"sigma": 0.3}
    assert (run.path / "metrics.jsonl").read_text().count('"sigma":') == 3
    assert set(run.strategy_state) >= {"mean", "sigma", "lengths", "generation"}
    assert main(["resume", "a"]) == 0


def test_settings_of_its_own_are_set() -> None:
    bounds = "--set strategy.lower=-2.0 --set strategy.upper=2.0"
    asked = f"--strategy truncation-ga --generations 1 --population 8 {bounds}"
    assert main(["evolve", "toy", *asked.split(), "--out", "a"]) == 0
    gain = runs.load("a").population["gain"]
    assert gain.min() < -0.3 and gain.max() > 0.3 and abs(gain).max() <= 2


@pytest.mark.parametrize(
    ("asked", "complaint"),
    [
        ("sep-cma", "unknown strategy 'sep-cma'; did you mean sep-cma-es"),
        ("map-elites", "unknown strategy 'map-elites'"),
        ("truncation-ga", "truncation-ga needs a value for lower and upper"),
        ("openai-es --population 7", "population_size must be an even number >= 2"),
    ],
)
def test_what_cannot_be_is_refused_in_one_sentence(
    asked: str, complaint: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main(["evolve", "toy", "--strategy", *asked.split()]) == 2
    captured = capsys.readouterr()
    assert complaint in captured.err and captured.err.count("\n") == 1
    assert not list(tmp_path.iterdir())
