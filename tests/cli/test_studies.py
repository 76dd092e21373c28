"""Tests of studies and of runs that start from others, from the command line."""

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
import toy
from terminal import start, wait_for_lines

from mjxwalk import experiments, runs, walkers
from mjxwalk.cli import main
from mjxwalk.evolution import runner
from mjxwalk.experiments import run_config, study_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.experiments.study_config import StudyConfig
from mjxwalk.runs import RunError, inheritance, study

PHASES = ("1-zero", "2-near", "3-pruned")


@pytest.fixture(autouse=True)
def in_new_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished study of the toys."""
    path = tmp_path_factory.mktemp("studies") / "whole"
    with pytest.MonkeyPatch.context() as patch:
        toy.install(patch)
        assert main(["evolve", "toys", "--seed", "3", "--out", str(path)]) == 0
    return path


def same_run(one: Path, other: Path) -> bool:
    a, b = runs.load(one), runs.load(other)
    files = ["champion.npz", *(["start.npz"] if (one / "start.npz").exists() else [])]
    return (
        a.generation == b.generation
        and list(a.arrays) == list(b.arrays)
        and all(a.arrays[name].tobytes() == b.arrays[name].tobytes() for name in a.arrays)
        and all((one / file).read_bytes() == (other / file).read_bytes() for file in files)
    )


def same_study(one: Path, other: Path) -> bool:
    names = ("winner.npz", "tournament.json")
    return all(
        same_run(one / phase, other / phase)
        and all((one / phase / n).read_bytes() == (other / phase / n).read_bytes() for n in names)
        for phase in PHASES
    )


def test_each_phase_starts_where_the_one_before_ended(whole: Path) -> None:
    assert sorted(p.name for p in whole.iterdir() if p.is_dir()) == list(PHASES)
    zero, near, pruned = (runs.load(whole / phase) for phase in PHASES)
    winner = walkers.best(whole / "1-zero")
    assert (winner.rank, winner.generation) == ("winner", 4)
    assert zero.config["origin"] is None
    assert near.config["origin"] == {"source": "../1-zero", "generation": 4}
    assert pruned.config["origin"] == {"source": "../2-near", "generation": 4}
    given = inheritance.read(whole / "2-near")
    np.testing.assert_array_equal(given.genotype["gain"], winner.genotype.gain)
    taken = inheritance.read(whole / "3-pruned")
    np.testing.assert_array_equal(
        taken.strategy["population.gain"], near.strategy_state["population.gain"]
    )
    np.testing.assert_array_equal(taken.elite_fitness, near.part("elites")["fitness"][-4:])


def test_a_phase_that_prunes_ends_when_its_strategy_has(whole: Path) -> None:
    pruned = runs.load(whole / "3-pruned")
    assert pruned.strategy_state["finished"]
    assert pruned.generation == len(pruned.metrics["generation"]) < 30
    assert pruned.result is not None and pruned.result.generations == pruned.generation
    # Of 16 walkers the elite alone lost no link before generation 1.
    assert pruned.metrics["strategy.num_pruned"].tolist() == [15, *[0] * (pruned.generation - 1)]


def test_a_study_twice_is_the_same_and_a_phase_alone_is_that_phase(
    whole: Path, tmp_path: Path
) -> None:
    assert main(["evolve", "toys", "--seed", "3", "--out", "again"]) == 0
    assert same_study(whole, tmp_path / "again")
    one = ["evolve", "toys/near", "--from", str(whole / "1-zero"), "--seed", "3", "--out", "alone"]
    assert main(one) == 0
    assert same_run(whole / "2-near", tmp_path / "alone")
    assert runs.load("alone").config["origin"]["source"] == str(whole / "1-zero")
    # The folder it came from is not needed any more.
    shutil.copytree("alone", "resumed")
    shutil.rmtree("resumed/checkpoints")
    for file in ("result.json", "champion.npz", "metrics.jsonl"):
        Path("resumed", file).unlink()
    shutil.rmtree("again")
    assert main(["resume", "resumed"]) == 0
    assert same_run(whole / "2-near", tmp_path / "resumed")


def lose_result(path: Path) -> None:
    for file in ("result.json", "champion.npz", "winner.npz", "tournament.json"):
        (path / file).unlink()


def lose_last_generations(path: Path) -> None:
    lose_result(path)
    newest = max(int(p.name) for p in (path / "checkpoints").iterdir())
    shutil.rmtree(path / "checkpoints" / str(newest))


def lose_tournament(path: Path) -> None:
    (path / "tournament.json").unlink()


def lose_all_but_start(path: Path) -> None:
    for each in path.iterdir():
        if each.is_dir():
            shutil.rmtree(each)
        elif each.name != "start.npz":
            each.unlink()


@pytest.mark.parametrize(
    "lose", [lose_result, lose_last_generations, lose_tournament, lose_all_but_start, shutil.rmtree]
)
@pytest.mark.parametrize("phase", [1, 2])
def test_a_study_killed_anywhere_resumes_to_the_same_bits(
    whole: Path, tmp_path: Path, lose: Callable[[Path], None], phase: int
) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(whole, copy)
    lose(copy / PHASES[phase])
    for later in PHASES[phase + 1 :]:
        shutil.rmtree(copy / later)
    assert main(["resume", "copy"]) == 0
    assert same_study(whole, copy)


@pytest.mark.slow
def test_a_study_killed_in_its_second_phase_resumes_to_the_same_bits(tmp_path: Path) -> None:
    settings = ["--seed", "4", "--set", "near.env.delay_s=0.02", "--set", "near.generations=25"]
    assert main(["evolve", "toys", *settings, "--out", "whole"]) == 0
    process = start("evolve", "toys", *settings, "--out", "killed")
    wait_for_lines(Path("killed/2-near/metrics.jsonl"), 9)
    process.kill()
    process.communicate()
    assert not Path("killed/2-near/result.json").exists()
    assert main(["resume", "killed"]) == 0
    assert same_study(tmp_path / "whole", tmp_path / "killed")


def test_a_finished_study_is_shown_and_left_alone(
    whole: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = {path: path.stat().st_mtime_ns for path in whole.rglob("*") if path.is_file()}
    assert main(["resume", str(whole)]) == 0
    assert "toys is finished" in capsys.readouterr().out
    assert {path: path.stat().st_mtime_ns for path in before} == before


def test_list_shows_the_phases_of_a_study(whole: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "--runs", str(whole.parent)]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"whole/1-zero +finished +generation 6 of 6 +champion", shown)
    assert re.search(r"whole/2-near +finished +generation 4 of 4 +champion", shown)


def test_settings_of_a_study_belong_to_its_phases() -> None:
    flags = "--scale 0.5 --population 12 --terrains 1 --roughness 0.3 --keep all --out a"
    more = "--set near.strategy.sigma=0.1 --set pruned.pruning.settle=1"
    assert main(["evolve", "toys", *flags.split(), *more.split()]) == 0
    settings = study_config.read(Path("a"))
    zero, near, pruned = (experiment for _, experiment in settings.phases)
    assert settings.scale == 0.5 and settings.keep is None
    assert (zero.generations, near.generations, pruned.generations) == (3, 2, 15)
    for each in (zero, near, pruned):
        assert (each.population_size, each.terrains_per_evaluation) == (12, 1)
        assert each.env.terrain.roughness == 0.3
    assert (zero.strategy.options["sigma"], near.strategy.options["sigma"]) == (0.05, 0.1)
    assert (pruned.pruning.every, pruned.pruning.settle) == (1, 1)
    assert experiments.of_run(runs.load("a/2-near")) == near


def test_an_experiment_that_starts_from_zero_may_start_from_a_winner(whole: Path) -> None:
    args = ["evolve", "toy", "--generations", "1", "--out", "a"]
    assert main([*args, "--from", str(whole / "3-pruned")]) == 0
    run = runs.load("a")
    assert run.config["experiment"]["start"] == "winner"
    winner = walkers.best(whole / "3-pruned").genotype
    np.testing.assert_array_equal(inheritance.read(Path("a")).genotype["gain"], winner.gain)


@pytest.mark.parametrize(
    ("args", "complaint"),
    [
        (["toys", "--from", "x"], "toys is a study and starts from zero; --from is for one of"),
        (["toys", "--generations", "5"], "use --scale, or --set PHASE.generations=NUMBER"),
        (["toys", "--scale", "0"], "--scale must be a number above 0 and at most 10000, got 0.0"),
        (["toys", "--scale", "nan"], "--scale must be a number above 0 and at most 10000, got nan"),
        (["toys", "--set", "env.friction=1"], "--set of a study needs PHASE.PATH=VALUE"),
        (["toys", "--set", "neer.env.friction=1"], "did you mean near"),
        (["toys", "--set", "near.env.frction=1"], "unknown setting env.frction"),
        (["toys", "--set", "near.strategy.sigma=-1"], "sigma"),
        (["toys", "--engine", "lanes"], "engine must be one of auto, mjx, got 'lanes'"),
        (["toys/near"], "toys/near starts from the winner of another run; name it with --from RUN"),
        (["toys/pruned"], "starts from the population of another run"),
        (["toys/nera", "--from", "x"], "unknown experiment 'toys/nera'; did you mean toys/near"),
        (["toys/near", "--from", "x"], "x does not exist"),
        (["toys/near", "--from", "zoo:nobody"], "nobody"),
        (["toys/pruned", "--from", "zoo:nobody"], "zoo:nobody is a single walker"),
        (["toy", "--links", "nowhere.json"], "nowhere.json could not be read"),
    ],
)
def test_wrong_input_is_one_sentence_and_leaves_nothing(
    args: list[str], complaint: str, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main(["evolve", *args, "--out", "new"]) == 2
    captured = capfd.readouterr()
    assert captured.out == ""
    assert complaint in captured.err
    assert re.fullmatch(r"mjxwalk: [^\n]+\n", captured.err)
    assert not list(tmp_path.iterdir())


def test_a_study_is_named_where_a_run_is_wanted(
    whole: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    for phase in ("toys/near", "toys/pruned"):
        assert main(["evolve", phase, "--from", str(whole), "--out", "a"]) == 2
        error = capfd.readouterr().err
        assert all(str(whole / name) in error for name in PHASES), error
    assert main(["evolve", "--out", str(whole)]) == 2
    assert "already holds a study; continue it with" in capfd.readouterr().err
    assert main(["evolve", "toys", "--out", str(whole)]) == 2
    assert "already holds a study; continue it with" in capfd.readouterr().err


def test_a_study_in_a_folder_in_use_is_refused(capfd: pytest.CaptureFixture[str]) -> None:
    run_config.create(Path("a"), Config(experiment=toy.Toy()))
    assert main(["evolve", "toys", "--out", "a"]) == 2
    assert "a already holds a run" in capfd.readouterr().err
    Path("b").mkdir()
    Path("b/thesis.tex").touch()
    with pytest.raises(RunError, match="not an empty folder"):
        study.check_free(Path("b"))


def test_a_study_s_settings_read_back_equal_and_damage_is_one_sentence(tmp_path: Path) -> None:
    settings = StudyConfig(name="toys", phases=toy.STUDY.phases, seed=7, scale=0.5, keep=None)
    study_config.create(tmp_path / "a", settings)
    assert study_config.read(tmp_path / "a") == settings
    file = tmp_path / "a" / study.FILE
    data = json.loads(file.read_text())
    for changes, complaint in (
        ({"schema": 9}, "version 9"),
        ({"colour": 1}, "colour"),
        ({"keep": 0}, "keep must be from 1 to"),
        ({"scale": 1e9}, "scale must be above 0 and at most 10000, got 1000000000.0"),
        ({"phases": []}, "phases must be one at least"),
        (
            {"phases": [{**data["phases"][0], "name": "a/../../../elsewhere"}]},
            "phases must be named by letters, digits and -",
        ),
        ({"phases": [{"name": "zero", "experiment": {"name": "toys/zero"}}]}, "is missing"),
    ):
        file.write_bytes(msgspec.json.encode({**data, **changes}))
        with pytest.raises(RunError, match=complaint) as caught:
            study_config.read(tmp_path / "a")
        assert "\n" not in str(caught.value)
    file.write_bytes(file.read_bytes()[:30])
    with pytest.raises(RunError, match="cannot be read"):
        study_config.read(tmp_path / "a")


def test_the_tournament_shrinks_with_the_study(
    whole: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[str, int, int]] = []

    def compete(entrants: object, *, engine: str, seed: int, terrains: int, say: object) -> object:
        asked.append((engine, seed, terrains))
        raise RunError("enough")

    monkeypatch.undo()  # the toys' own tournament
    toy.install(monkeypatch)
    monkeypatch.setattr(runner, "hold_tournament", HOLD)
    monkeypatch.setattr(runner.tournament, "compete", compete)
    for scale in (1.0, 0.1, 0.001):
        settings = StudyConfig(name="toys", phases=toy.STUDY.phases, seed=5, scale=scale)
        with pytest.raises(RunError, match="enough"):
            runner.hold_tournament(whole / "1-zero", settings, print)
    assert asked == [("mjx", 5, 1000), ("mjx", 5, 100), ("mjx", 5, 20)]


HOLD = runner.hold_tournament


def test_a_phase_in_a_config_is_found_again(whole: Path) -> None:
    assert run_config.read(whole / "2-near").experiment == toy.STUDY.phase("near")
