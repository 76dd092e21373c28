"""Tests of `mjxwalk report` on the toys, as a user calls it."""

import shutil
from pathlib import Path

import pandas as pd
import pytest
import toy
from report.outline import Outline

from mjxwalk.cli import main

EVIL = "<script>alert(1)</script>"


@pytest.fixture(autouse=True)
def in_new_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished study of the toys."""
    path = tmp_path_factory.mktemp("report") / "study"
    with pytest.MonkeyPatch.context() as patch:
        toy.install(patch)
        assert main(["evolve", "toys", "--seed", "3", "--out", str(path)]) == 0
    return path


def evolve(out: str, *flags: str) -> None:
    assert main(["evolve", "toy", "--generations", "2", *flags, "--out", out]) == 0


def report(*args: str, folder: str = "report") -> Outline:
    assert main(["report", *args]) == 0
    outline = Outline(Path(folder, "report.html").read_text())
    assert not outline.unbalanced and not outline.named("script")
    beside = {path.name for path in Path(folder).glob("*.csv")}
    assert {
        e.attributes["href"] for e in outline.named("a") if "download" in e.attributes
    } == beside
    return outline


def test_one_run_is_reported_in_its_own_folder(capsys: pytest.CaptureFixture[str]) -> None:
    evolve("a", "--seed", "7")
    capsys.readouterr()
    outline = report("a", folder="a/report")
    assert capsys.readouterr().out.splitlines()[0] == "a/report/report.html"
    assert "toy, 1 run" in outline.text
    assert "mjxwalk evolve toy --seed 7 --set generations=2" in outline.text
    assert "mjxwalk tournament a" in outline.text
    assert "One run of each phase" in outline.text
    runs = pd.read_csv("a/report/runs.csv")
    assert runs[["seed", "generations", "finished"]].values.tolist() == [[7, 2, True]]
    # The run stays a run.
    assert main(["resume", "a"]) == 0


def test_ten_runs_are_averaged() -> None:
    names = [f"run{seed}" for seed in range(10)]
    for seed, name in enumerate(names):
        evolve(name, "--seed", str(seed))
    outline = report(*names)
    assert "toy, 10 runs" in outline.text
    best = [pd.read_json(f"{n}/metrics.jsonl", lines=True)["best_fitness"] for n in names]
    drawn = pd.read_csv("report/fitness.csv")
    assert drawn["fittest_m"].tolist() == pytest.approx(
        pd.concat(best, axis=1).mean(axis=1).tolist()
    )
    assert drawn["fittest_sd_m"].tolist() == pytest.approx(
        pd.concat(best, axis=1).std(axis=1).tolist()
    )
    assert len(pd.read_csv("report/winners-by-run.csv")) == 10


def test_a_run_that_was_cut_short_says_so() -> None:
    evolve("a")
    for file in ("result.json", "champion.npz"):
        Path("a", file).unlink()
    outline = report("a", "--out", "page", folder="page")
    assert "a: cut short at 2 of 2" in outline.text
    assert "mjxwalk resume a" in outline.text
    assert "no tournament yet" in outline.text


def test_a_study_is_reported_phase_by_phase(study: Path) -> None:
    outline = report(str(study), "--out", "page", folder="page")
    assert pd.read_csv("page/runs.csv")["experiment"].tolist() == [
        "toys/zero",
        "toys/near",
        "toys/pruned",
    ]
    phases = pd.read_csv("page/fitness.csv")["phase"].unique().tolist()
    assert phases == ["zero", "near", "pruned: pruning", "after"]
    assert "mjxwalk evolve toys --seed 3" in outline.text


def test_a_study_of_which_only_the_first_phase_is_there(study: Path) -> None:
    shutil.copytree(study, "begun")
    shutil.rmtree("begun/2-near")
    shutil.rmtree("begun/3-pruned")
    outline = report("begun", folder="begun/report")
    assert "begun: near, pruned" in outline.text
    assert len(pd.read_csv("begun/report/runs.csv")) == 1


def test_a_study_and_one_of_its_phases_alone_are_averaged(study: Path) -> None:
    args = ["evolve", "toys/near", "--from", str(study / "1-zero"), "--seed", "8"]
    assert main([*args, "--out", "near"]) == 0
    report(str(study), "near")
    near = pd.read_csv("report/fitness.csv").query("phase == 'near'")
    assert set(near["runs"]) == {2}


def test_a_run_folder_with_a_script_for_a_name_does_nothing_in_the_page() -> None:
    evolve(EVIL)
    outline = report(EVIL, "--out", "page", folder="page")
    assert outline.text.count(EVIL) >= 2
    assert not [n for e in outline.elements for n in e.attributes if n.startswith("on")]


def empty(path: str) -> None:
    evolve(path)
    for file in ("metrics.jsonl", "result.json"):
        Path(path, file).unlink()
    shutil.rmtree(Path(path, "checkpoints"))


@pytest.mark.parametrize(
    ("args", "complaint"),
    [
        ([], "name at least one run"),
        (["nowhere"], "nowhere does not exist"),
        (["."], "holds several runs; name one of"),
        (["a", "./a"], "a is named twice"),
        (["empty"], "empty has no generation yet"),
        (["a", "wide"], "cannot be averaged: population_size is 16 in the one and 8 in the other"),
        (["a", "near"], "a is of the experiment toy and near of toys/near"),
        (["zoo:planar-lpd"], "a report needs a run's folder"),
        (["a", "--trials", "-1"], "--trials must not be negative, got -1"),
        (["a", "--seed", "-1"], "--seed must be a whole number from 0 to"),
        (["a", "--out", "a/config.json"], "could not be made: file exists"),
    ],
)
def test_what_cannot_be_reported_is_one_sentence(
    args: list[str], complaint: str, study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    evolve("a")
    evolve("wide", "--population", "8")
    empty("empty")
    shutil.copytree(study / "2-near", "near")
    capsys.readouterr()
    assert main(["report", *args]) == 2
    shown = capsys.readouterr()
    assert shown.err.startswith("mjxwalk: ") and shown.err.count("\n") == 1
    assert complaint in shown.err
    assert not list(Path().rglob("report.html"))
