"""Tests of `mjxwalk tournament`, as a user calls it, on runs of the toy."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import toy

from mjxwalk import runs, tournament, walkers
from mjxwalk.cli import main
from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.runs.result import FILE as RESULT
from mjxwalk.tournament import results
from mjxwalk.tournament.results import WINNER_FILE

FILES = (results.FILE, WINNER_FILE)


@pytest.fixture(scope="module")
def evolved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a finished run."""
    path = tmp_path_factory.mktemp("runs") / "a"
    with pytest.MonkeyPatch.context() as patch:
        toy.install(patch)
        assert main(["evolve", "--generations", "3", "--out", str(path)]) == 0
    return path


@pytest.fixture(autouse=True)
def toy_run(
    evolved: Path,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)
    shutil.copytree(evolved, "a")
    capfd.readouterr()


def test_the_run_gets_its_winner_and_the_figures(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["tournament", "a", "--terrains", "30", "--seed", "4"]) == 0
    shown = capfd.readouterr()
    assert shown.err == ""
    assert "the winner of a is the fittest of generation" in shown.out
    held = tournament.read(Path("a"))
    assert held is not None
    assert (held.entrants, held.seed, held.conditions[0].trials) == (3, 4, 30)
    best = walkers.best("a")
    assert (best.rank, best.generation) == ("winner", held.winner_generation)


def test_a_run_that_is_not_finished_has_elites_too() -> None:
    Path("a", RESULT).unlink()
    assert main(["tournament", "a", "--terrains", "5"]) == 0
    assert walkers.best("a").rank == "winner"


def test_on_other_ground_the_run_is_left_as_it_is(capfd: pytest.CaptureFixture[str]) -> None:
    args = ["tournament", "a", "--terrains", "5", "--json", "b.json"]
    assert main([*args, "--roughness", "0.5"]) == 0
    assert "a is left as it is" in capfd.readouterr().out
    assert not any(Path("a", name).exists() for name in FILES)
    assert json.loads(Path("b.json").read_text())["roughness_m"] == 0.5
    assert main([*args, "--roughness", "0.01"]) == 0  # that of the toy
    assert all(Path("a", name).exists() for name in FILES)


@pytest.mark.parametrize(
    ("args", "complaint"),
    [
        ([], "RUN|zoo:NAME"),
        (["nowhere"], "nowhere does not exist"),
        (["."], ". holds several runs; name one of a, begun"),
        (["begun"], "begun has not saved a generation yet"),
        (["zoo:nobody"], "there is no 'nobody' in the zoo"),
        (["a", "--terrains", "0"], "--terrains must be at least 1, got 0"),
        (["a", "--terrains", "many"], "--terrains"),
        (["a", "--seed", "-1"], "--seed must be a whole number from 0 to 4294967295"),
        (["a", "--roughness", "-1"], "roughness must not be negative, got -1.0"),
        (["a", "--roughness", "nan"], "--roughness must be a number, got 'nan'"),
        (["a", "--engine", "warp"], "invalid choice 'warp'"),
        (["a", "--engine", "lanes"], "engine must be one of auto, mjx, got 'lanes'"),
        (["a", "--json", "no/x.json"], "--json no/x.json is in no folder that is there"),
    ],
)
def test_wrong_input_is_one_sentence_and_leaves_nothing(
    args: list[str], complaint: str, capfd: pytest.CaptureFixture[str]
) -> None:
    run_config.create(Path("begun"), Config(experiment=toy.Toy()))
    before = sorted(Path().rglob("*"))
    assert main(["tournament", *args]) == 2
    captured = capfd.readouterr()
    assert complaint in captured.err
    assert re.fullmatch(r"mjxwalk: [^\n]+\n", captured.err)
    assert sorted(Path().rglob("*")) == before


@pytest.mark.parametrize("content", [b"", b"{", b'{"entrants": "many"}', b"\xff"])
def test_a_damaged_tournament_is_one_sentence_and_a_new_one_replaces_it(content: bytes) -> None:
    Path("a", results.FILE).write_bytes(content)
    with pytest.raises(runs.RunError, match="cannot be read|was changed since") as caught:
        walkers.best("a")
    assert "\n" not in str(caught.value)
    assert main(["tournament", "a", "--terrains", "5"]) == 0
    assert walkers.best("a").rank == "winner"


def test_a_run_that_cannot_be_written_is_told_before_any_trial_unless_figures_go_elsewhere(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    access = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: str(path) != "a" and access(path, mode))
    before = sorted(Path("a").iterdir())
    assert main(["tournament", "a", "--terrains", "5"]) == 2
    told = capfd.readouterr()
    assert told.out == "" and told.err == (
        "mjxwalk: a cannot be written: permission denied; name a file for the figures with --json\n"
    )
    assert main(["tournament", "a", "--terrains", "5", "--json", "figures.json"]) == 0
    assert "a is left as it is: it cannot be written" in capfd.readouterr().out
    assert Path("figures.json").exists() and sorted(Path("a").iterdir()) == before


def test_a_damaged_winner_is_one_sentence() -> None:
    assert main(["tournament", "a", "--terrains", "5"]) == 0
    path = Path("a", WINNER_FILE)
    path.write_bytes(path.read_bytes()[:-30])
    with pytest.raises(runs.RunError, match="winner.npz is not the file that its run wrote"):
        walkers.best("a")
    path.unlink()
    with pytest.raises(runs.RunError, match="winner.npz does not exist"):
        walkers.best("a")


def test_damaged_checkpoints_are_one_sentence(capfd: pytest.CaptureFixture[str]) -> None:
    for path in Path("a/checkpoints").iterdir():
        shutil.rmtree(path / "arrays")
    assert main(["tournament", "a"]) == 2
    error = capfd.readouterr().err
    assert re.fullmatch(r"mjxwalk: a has no checkpoint that can be read: [^\n]+\n", error)


@pytest.mark.slow
def test_ctrl_c_leaves_the_run_as_it_was() -> None:
    assert main(["evolve", "--generations", "3", "--set", "env.delay_s=1", "--out", "slow"]) == 0
    before = sorted(Path("slow").rglob("*"))
    process = subprocess.Popen(
        [sys.executable, toy.__file__, "tournament", "slow", "--terrains", "5000"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    assert process.stdout is not None
    assert process.stdout.readline().startswith("comparing 3 walkers")
    assert process.stdout.readline().startswith("as evolved")
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=60)
    assert (process.returncode, error) == (130, "")
    assert sorted(Path("slow").rglob("*")) == before
