"""Tests of the command line: what it prints, what it refuses, and how it ends."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import toy
from terminal import start, wait_for_lines

from mjxwalk import evaluation, experiments, runs
from mjxwalk.cli import main
from mjxwalk.cli.commands import COMMANDS
from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.runs import folder

TOY = Path(toy.__file__)


@pytest.fixture(autouse=True)
def in_new_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    shown = capsys.readouterr().out
    assert all(re.search(rf"^  {name} ", shown, re.MULTILINE) for name in COMMANDS)


def test_help_takes_less_than_half_a_second() -> None:
    times: list[float] = []
    for _ in range(3):
        started = time.perf_counter()
        subprocess.run([sys.executable, "-m", "mjxwalk", "--help"], check=True, capture_output=True)
        times.append(time.perf_counter() - started)
    assert min(times) < 0.5


@pytest.mark.parametrize("args", [["--help"], ["evolve", "--help"], ["list"], ["evolve", "lpd"]])
def test_jax_is_not_imported_before_it_is_needed(args: list[str]) -> None:
    code = f"""
import sys
from mjxwalk.cli import main
try:
    main({args})
except SystemExit:
    pass
assert "jax" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


@pytest.mark.parametrize(
    ("args", "complaint"),
    [
        (["evolv"], "unknown command 'evolv'; did you mean evolve?"),
        (["evolve", "toi"], "unknown experiment 'toi'; did you mean toy or toys?"),
        (["evolve", "--population", "-5"], "--population must be at least 1, got -5"),
        (["evolve", "--population", "many"], "--population must be a whole number, got 'many'"),
        (["evolve", "--generations", "0"], "--generations must be at least 1, got 0"),
        (["evolve", "--roughness", "rough"], "--roughness must be a number, got 'rough'"),
        (["evolve", "--roughness", "nan"], "--roughness must be a number, got 'nan'"),
        (["evolve", "--roughness", "-1"], "roughness must not be negative, got -1.0"),
        (["evolve", "--seed", "-1"], "--seed must be a whole number from 0 to 4294967295"),
        (["evolve", "--keep", "0"], "--keep must be at least 1, got 0"),
        (["evolve", "--engine", "warp"], "invalid choice 'warp' for argument '--engine'"),
        (["evolve", "--engine", "lanes"], "engine must be one of auto, mjx, got 'lanes'"),
        (["evolve", "--colour"], "unrecognized options: --colour"),
        (["list", "."], "unrecognized options: .;"),
        (["evolve", "--set", "name=other"], "name is no setting"),
        (["evolve", "toys", "--set", "near.name=other"], "name is no setting"),
        (["evolve", "--set", "friction"], "--set needs PATH=VALUE, got 'friction'"),
        (["evolve", "--set", "env.frction=1"], "unknown setting env.frction"),
        (["evolve", "--set", "strategy.sgma=1"], "unknown option 'sgma'"),
        (["evolve", "--set", "strategy.sigma=-1"], "sigma"),
        (["evolve", "--set", "strategy.name=gaa"], "unknown strategy 'gaa'"),
        (["resume"], "RUN"),
        (["resume", "nowhere"], "nowhere does not exist"),
        (["resume", "."], ". is no run: it has no config.json"),
    ],
)
def test_wrong_input_is_one_sentence_and_leaves_nothing(
    args: list[str], complaint: str, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main(args) == 2
    captured = capfd.readouterr()
    assert captured.out == ""
    assert complaint in captured.err
    assert re.fullmatch(r"mjxwalk: [^\n]+\n", captured.err)
    assert not list(tmp_path.iterdir())


def test_a_wrong_value_is_named_where_the_terminal_has_letters_of_ascii_only() -> None:
    process = subprocess.run(
        [sys.executable, str(TOY), "evolve", "--seed", "x"],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )
    assert process.returncode == 2
    assert "--seed must be a whole number from 0 to 4294967295, got 'x'" in process.stderr


def test_an_out_in_use_is_refused_and_not_touched(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    run_config.create(tmp_path / "a", Config(experiment=toy.Toy()))
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "thesis.tex").touch()
    before = sorted(tmp_path.rglob("*"))
    assert main(["evolve", "--out", "a"]) == 2
    assert "a already holds a run; continue it with `mjxwalk resume a`" in capsys.readouterr().err
    assert main(["evolve", "--out", "b"]) == 2
    assert "b exists and is not an empty folder" in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == before


def test_a_run_being_worked_on_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    run_config.create(tmp_path / "a", Config(experiment=toy.Toy()))
    with folder.locked(tmp_path / "a"):
        assert main(["resume", "a"]) == 2
    assert "another process is working on a" in capsys.readouterr().err


def test_evolve_uses_every_flag_and_tells_what_to_do_next(
    capfd: pytest.CaptureFixture[str],
) -> None:
    flags = "--generations 2 --population 8 --terrains 3 --roughness 0.5 --seed 4 --keep all"
    more = "--set env.friction=0.8 --set strategy.sigma=0.1 --save-every 2 --out a"
    assert main(["evolve", "toy", *flags.split(), *more.split()]) == 0
    captured = capfd.readouterr()
    assert captured.err == ""
    assert "generation 2/2" in captured.out
    assert "next: mjxwalk report a\n      mjxwalk watch a\n" in captured.out
    run = runs.load("a")
    assert (run.config["seed"], run.config["keep"], run.config["save_every"]) == (4, None, 2)
    experiment = experiments.of_run(run)
    assert (experiment.generations, experiment.population_size) == (2, 8)
    assert experiment.terrains_per_evaluation == 3
    assert experiment.env == toy.World(friction=0.8, terrain=toy.Ground(roughness=0.5))
    assert experiment.strategy.options == {"sigma": 0.1, "initial_sigma": 0.3}
    assert run.manifest["engine"] == "mjx"
    assert run.manifest["packages"]["jax"]


def test_fine_trials_have_an_evaluator_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    timesteps: list[float] = []

    class Noting(toy.ToyEvaluator):
        def __init__(self, study: toy.Toy, engine: str) -> None:
            super().__init__(study, engine)
            timesteps.append(study.env.timestep)

    monkeypatch.setattr(evaluation, "make_evaluator", Noting)
    goal = "--set goal.trials=5 --set goal.duration=1e9 --set goal.fine_factor=5"
    assert main(["evolve", *goal.split(), "--out", "a"]) == 0
    assert timesteps == [0.001]
    assert main(["evolve", *goal.split(), "--set", "goal.fine_trials=3", "--out", "b"]) == 0
    assert timesteps[1:] == [0.001, 0.0002]
    # Being tried more changes nothing of what evolves.
    a, b = (runs.load(path).population["gain"] for path in ("a", "b"))
    assert a.tobytes() == b.tobytes()


def test_list_shows_experiments_and_runs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evolve", "--generations", "2"]) == 0
    run_config.create(Path("runs/begun"), Config(experiment=toy.Toy()))
    Path("runs/other").mkdir()
    capsys.readouterr()
    assert main(["list"]) == 0
    shown = capsys.readouterr().out
    assert "Experiments\n  toy  no physics, for tests\n" in shown
    assert re.search(r"^  toys +three phases.*\n  toys/zero +a phase", shown, re.MULTILINE)
    assert re.search(
        r"toy-0-\d{8}-\d{6}  finished  generation 2 of 2 +champion fitness -?\d[\d.]+, \d", shown
    )
    assert re.search(r"begun +stopped +generation 0 of 6 +-", shown)
    assert "other" not in shown


def test_resuming_a_finished_run_shows_its_result(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evolve", "--generations", "1", "--out", "a"]) == 0
    capsys.readouterr()
    assert main(["resume", "a"]) == 0
    assert "a is finished" in capsys.readouterr().out


def test_doctor_tells_versions_and_devices(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor"]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"mujoco +3\.17\.0", shown)
    assert re.search(r"devices +\d+ x", shown)
    assert "engine   auto is" in shown


@pytest.mark.slow
def test_a_run_killed_at_any_moment_resumes_to_the_same_bits() -> None:
    settings = ["--generations", "25", "--seed", "3", "--set", "env.delay_s=0.02"]
    assert main(["evolve", *settings, "--out", "whole"]) == 0
    process = start("evolve", *settings, "--out", "killed")
    for lines in (7, 15):
        wait_for_lines(Path("killed/metrics.jsonl"), lines)
        process.kill()
        process.communicate()
        assert not Path("killed/result.json").exists()
        if lines == 7:
            process = start("resume", "killed")
    assert main(["resume", "killed"]) == 0
    whole, killed = runs.load("whole"), runs.load("killed")
    assert whole.generation == killed.generation == 25
    assert list(whole.arrays) == list(killed.arrays)
    for name, array in whole.arrays.items():
        assert array.tobytes() == killed.arrays[name].tobytes(), name
    assert whole.metrics["best_fitness"].tolist() == killed.metrics["best_fitness"].tolist()
    assert Path("whole/champion.npz").read_bytes() == Path("killed/champion.npz").read_bytes()


@pytest.mark.slow
def test_ctrl_c_saves_and_says_how_to_go_on() -> None:
    process = start("evolve", "--generations", "1000", "--set", "env.delay_s=0.05", "--out", "a")
    wait_for_lines(Path("a/metrics.jsonl"), 3)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (130, "")
    assert "go on with: mjxwalk resume a" in out
    run = runs.load("a")
    # A line is written before its checkpoint; one that Ctrl-C leaves without is cut at the resume.
    assert len(run.metrics["generation"]) - run.generation in (0, 1)
    assert not folder.is_locked(Path("a"))


def test_a_second_ctrl_c_ends_at_once_even_inside_foreign_code() -> None:
    code = """
import hashlib
from mjxwalk.cli.interrupt import Interrupt
with Interrupt(lambda text: print(text, flush=True)):
    print("ready", flush=True)
    hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)  # cannot be interrupted, for many minutes
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    assert process.stdout.readline() == "stopping and saving; again to stop at once\n"
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=20) == 130
    process.stdout.close()


@pytest.mark.slow
def test_a_damaged_checkpoint_makes_no_noise(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["evolve", "--generations", "3", "--out", "a"]) == 0
    Path("a/result.json").unlink()
    array = Path("a/checkpoints/3/arrays/0")
    array.write_bytes(array.read_bytes()[:-20])
    process = start("resume", "a")
    out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, "")
    assert "checkpoints/3 is damaged" in out
    assert "going on from generation 2" in out


@pytest.mark.slow
def test_a_full_disk_is_one_sentence() -> None:
    # No file may grow beyond some 20 kB, and the population takes more.
    limited = ["sh", "-c", 'ulimit -f 40; exec "$@"', "sh", sys.executable, str(TOY)]
    process = subprocess.run(
        [*limited, "evolve", "--population", "4096", "--out", "a"], capture_output=True, text=True
    )
    assert process.returncode == 2
    reason = "generation 1 could not be saved in a/checkpoints: the disk is full"
    assert process.stderr == f"mjxwalk: {reason}\n"
