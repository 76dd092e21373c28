"""Tests of experiments of one's own, which a program registers by their names."""

import dataclasses
import json
from pathlib import Path

import pytest
import toy
from toy import Toy

from mjxwalk import cli, experiments, runs
from mjxwalk.errors import RunError
from mjxwalk.experiments import registry
from mjxwalk.runs import config, digests


@dataclasses.dataclass(frozen=True, kw_only=True)
class Mine(Toy):
    """An experiment with a setting that no other has."""

    name: str = "mine"
    colour: str = "red"


@pytest.fixture(autouse=True)
def nothing_registered(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.setattr(registry, "_REGISTERED", {})
    monkeypatch.chdir(tmp_path)


def test_runs_of_a_registered_experiment_read_back_and_go_on_by_name(
    capsys: pytest.CaptureFixture[str],
) -> None:
    experiments.register(Mine())
    short = ["--generations", "2", "--set", "colour=blue"]
    assert cli.main(["evolve", "mine", "--out", "a", *short]) == 0
    assert experiments.of_run(runs.load("a")).colour == "blue"
    assert isinstance(experiments.of_run(runs.load("a")), Mine)
    for path in ("a/result.json", "a/champion.npz"):
        Path(path).unlink()
    assert cli.main(["resume", "a"]) == 0
    assert cli.main(["list", "--runs", "."]) == 0
    shown = capsys.readouterr().out
    assert "mine  registered by this program" in shown and "a  finished" in shown


def test_without_its_registration_a_run_is_of_an_unknown_experiment(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    experiments.register(Mine())
    assert cli.main(["evolve", "mine", "--out", "a", "--generations", "2"]) == 0
    monkeypatch.setattr(registry, "_REGISTERED", {})
    with pytest.raises(RunError, match="unknown experiment 'mine'"):
        experiments.of_run(runs.load("a"))
    capsys.readouterr()
    assert cli.main(["resume", "a"]) == 2
    assert capsys.readouterr().err.startswith("mjxwalk: a/config.json: unknown experiment 'mine'")


def test_a_run_cannot_have_a_module_imported(tmp_path: Path) -> None:
    Path("stranger.py").write_text("raise SystemExit('imported')")
    assert cli.main(["evolve", "toy", "--out", "a", "--generations", "2"]) == 0
    file = Path("a", config.FILE)
    data = json.loads(file.read_text())
    for name in ("stranger", "stranger:TOY", "mjxwalk.experiments.solomon", "../stranger"):
        data["experiment"]["name"] = name
        file.write_bytes(digests.with_digest(data))
        with pytest.raises(ValueError, match="unknown experiment"):
            experiments.from_data(config.read_data(Path("a"))["experiment"])


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("toy", "choose another name"),
        ("toys", "choose another name"),
        ("toys/near", "name must be"),
        ("../mine", "name must be"),
        ("", "name must be"),
    ],
)
def test_a_name_that_cannot_be_is_refused(name: str, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        experiments.register(Mine(name=name))
    with pytest.raises(ValueError, match="must be a frozen dataclass"):
        experiments.register(Mine)


def test_an_experiment_may_be_registered_anew() -> None:
    experiments.register(Mine())
    experiments.register(Mine(colour="green"))
    assert experiments.get("mine") == Mine(colour="green")
