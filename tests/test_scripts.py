"""Tests of the scripts, each as a user calls it."""

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import toy

from mjxwalk import cli, runs

SCRIPTS = Path(__file__).parents[1] / "scripts"


def load(name: str) -> Any:
    spec = importlib.util.spec_from_file_location(name, SCRIPTS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


CHAMPION = load("champion").Champion
PLOT = load("plot_fitness").PlotFitness


@pytest.fixture(autouse=True)
def toy_run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)
    assert cli.main(["evolve", "--generations", "2", "--out", "a"]) == 0


def test_champion_shows_every_weight_and_writes_them(capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert cli.run("champion.py", CHAMPION, ["a", "--out", "weights.npz"]) == 0
    shown = capsys.readouterr().out.splitlines()
    assert shown[0].startswith("champion of generation")
    gain = runs.load("a").champion["gain"]
    assert shown[1].split() == ["network", "0", "input", "0", f"{gain[0, 0]:.4f}"]
    assert len(shown) == 1 + 6 + 1
    with np.load("weights.npz") as weights:
        np.testing.assert_array_equal(weights["gain"], gain)


def test_champion_of_an_unfinished_run_is_its_fittest(capsys: pytest.CaptureFixture[str]) -> None:
    Path("a/result.json").unlink()
    capsys.readouterr()
    assert cli.run("champion.py", CHAMPION, ["a"]) == 0
    assert "fittest of generation 2" in capsys.readouterr().out


def test_plot_fitness_draws_a_picture() -> None:
    assert cli.run("plot_fitness.py", PLOT, ["a", "--out", "figure.png"]) == 0
    assert Path("figure.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(("program", "command"), [("champion.py", CHAMPION), ("plot.py", PLOT)])
def test_no_run_is_one_sentence(
    program: str, command: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert cli.run(program, command, ["nowhere"]) == 2
    assert capsys.readouterr().err.startswith(f"{program}: nowhere does not exist")


def test_a_missing_matplotlib_is_one_sentence(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    real = importlib.util.find_spec

    def without(name: str, package: str | None = None) -> Any:
        return None if name == "matplotlib" else real(name, package)

    monkeypatch.setattr(importlib.util, "find_spec", without)
    assert cli.run("plot_fitness.py", PLOT, ["a"]) == 2
    assert "matplotlib is missing" in capsys.readouterr().err
