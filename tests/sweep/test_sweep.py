"""Tests of sweeps: their grid, their folder, and what becomes of their runs."""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Generator
from pathlib import Path
from typing import Any

import msgspec
import pytest
import toy

from mjxwalk.cli import main
from mjxwalk.cli.evolve import Evolve
from mjxwalk.cli.parsing import parse
from mjxwalk.cli.sweep_grid import is_of_sweep, make_plan
from mjxwalk.engines.lanes.cache import entries
from mjxwalk.errors import RunError
from mjxwalk.runs import config, digests, folder
from mjxwalk.sweep import local, plan, run_progress

FAKE = Path(__file__).with_name("fake.py")


@pytest.fixture(autouse=True)
def in_new_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(local, "PROGRAM", (sys.executable, str(FAKE)))


def told(name: str, place: str = "s") -> list[dict[str, Any]]:
    """Returns what the process of each start of a run said of itself."""
    lines = Path(place, "logs", f"{name}.log").read_text().splitlines()
    return [json.loads(line) for line in lines if line.startswith("{")]


def test_a_sweep_runs_all_and_repeats_none(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["sweep", "toy", "--seeds", "3", "--out", "s"]
    assert main(command) == 0
    shown = capsys.readouterr().out
    assert "seed-2 finished: 3 generations, champion 2.50 m" in shown
    assert "3 finished, best 2.50 m" in shown
    assert main(command) == 0
    assert main(["resume", "s"]) == 0
    for seed in range(3):
        assert [each["args"][0] for each in told(f"seed-{seed}")] == ["evolve"]
        assert run_progress.read(Path(f"s/seed-{seed}")).is_finished


def test_a_failed_run_is_told_not_fatal_and_tried_again(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["sweep", "toy", "--seeds", "2", "--set", "strategy.sigma=0.1,13", "--out", "s"]
    assert main(command) == 2
    captured = capsys.readouterr()
    assert "2 finished, 2 failed" in captured.out
    assert re.fullmatch(
        r"mjxwalk: 2 of 4 runs failed: sigma-13-seed-0, sigma-13-seed-1; sigma-13-seed-0: the "
        r"friction is too slippery; [^\n]+ `mjxwalk resume s` tries them again\n",
        captured.err,
    )
    Path("mended").touch()
    assert main(["resume", "s"]) == 0
    assert "4 finished" in capsys.readouterr().out
    assert [each["args"][0] for each in told("sigma-0.1-seed-0")] == ["evolve"]
    assert [each["args"][0] for each in told("sigma-13-seed-0")] == ["evolve", "resume"]


def test_the_same_grid_finds_its_folder_and_another_is_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["sweep", "toy", "--seeds", "1"]) == 0
    assert main(["sweep", "toy", "--seeds", "1", "--cores-per-run", "1"]) == 0
    assert main(["sweep", "toy", "--seeds", "2"]) == 0
    assert len(list(Path("runs").iterdir())) == 2
    place = next(Path("runs").iterdir())
    capsys.readouterr()
    assert main(["sweep", "toy", "--seeds", "3", "--out", str(place)]) == 2
    assert "holds another sweep; go on with it by `mjxwalk resume" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("args", "complaint"),
    [
        (["toi"], "unknown experiment 'toi'"),
        (["toys"], "toys is a study; sweep one of its phases zero, near, pruned"),
        (["toy", "--seeds", "0"], "--seeds must be at least 1, got 0"),
        (["toy", "--seeds", "1000000"], "these are 1000000 runs, more than 100000"),
        (["toy", "--set", "strategy.sigma=0.1,"], "has a comma without a value beside it"),
        (["toy", "--set", "strategy.sigma=1,2", "--set", "strategy.sigma=3,4"], "is there twice"),
        (["toy", "--set", "strategy.sigma=0.1,-1"], "sigma must be"),
        (["toy", "--cores-per-run", "4096"], "--cores-per-run is 4096, and this machine lends"),
        (["toy", "--cores-per-run", "0"], "--cores-per-run must be above 0"),
        (["toy", "--memory-per-run", "1e9"], "--memory-per-run is 1e+09 GB, and this machine has"),
        (["toy", "--memory-per-run", "0.1"], "--memory-per-run must be at least 0.4 GB"),
        (["toy", "--live"], "--live shows one run, and a sweep has several at a time"),
        (["toy", "--seed", "-1"], "--seed must be a whole number from 0 to 4294967295, got '-1'"),
        (["toy", "--address", "auto"], "--address goes with --executor ray"),
        (["toy", "--partition", "a"], "--partition goes with --executor slurm"),
        (["toy", "--processes", "2"], "--processes is for a run of several processes"),
        (["toy", "--set", "strategy.sigma=1", "--set", "strategy.sigma=2,3"], "is there twice"),
        (["toy", "--set", "strategy.sigma=0.1,0.10"], "are the same run; leave one out"),
        (["toy", "--executor", "ray"], "needs Ray, which is not installed"),
        (["toy", "--executor", "slurm"], "needs submitit, which is not installed"),
    ],
)
def test_wrong_input_is_one_sentence(
    args: list[str],
    complaint: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for extra in ("ray", "submitit"):
        monkeypatch.setitem(sys.modules, extra, None)
    assert main(["sweep", *args]) == 2
    error = capsys.readouterr().err
    assert complaint in error
    assert re.fullmatch(r"mjxwalk: [^\n]+\n", error)


@pytest.mark.parametrize(
    ("name", "args"),
    [
        ("../../elsewhere", ("toy",)),
        ("logs", ("toy",)),
        ("a", ("toy", "--out", "/elsewhere")),
        ("a", ("toy", "--help-me")),
        ("a", ("toy", "--distributed", "--coordinator", "elsewhere:1")),
        ("a", ("toy", "--live")),
    ],
)
def test_a_plan_that_leads_out_of_its_folder_is_refused(name: str, args: tuple[str, ...]) -> None:
    Path("s").mkdir()
    run = {"name": name, "args": args}
    data = {"schema": plan.SCHEMA, "runs": [run], "resources": {}}
    Path("s", plan.FILE).write_bytes(digests.with_digest(data))
    with pytest.raises(RunError):
        plan.read(Path("s"), is_of_sweep)


def test_a_changed_or_older_plan_is_one_sentence() -> None:
    plan.create(Path("s"), make_plan(Evolve(experiment="toy"), 1, plan.Resources()))
    file = Path("s", plan.FILE)
    whole = file.read_bytes()
    for content, complaint in (
        (whole.replace(b'"seed-0"', b'"seed-1"'), "was changed since it was written"),
        (whole[:-20], "cannot be read"),
        (msgspec.json.encode({"schema": 9}), "version 9"),
    ):
        file.write_bytes(content)
        with pytest.raises(RunError, match=complaint):
            plan.read(Path("s"), is_of_sweep)


def test_a_sweep_in_the_hands_of_another_process_is_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    planned = make_plan(Evolve(experiment="toy"), 1, plan.Resources())
    plan.create(Path("s"), planned)
    with folder.locked(Path("s")):
        assert main(["resume", "s"]) == 2
    assert "another process is working on s" in capsys.readouterr().err


def test_ctrl_c_stops_the_runs_and_says_how_to_go_on() -> None:
    code = f"""
import sys, signal, pytest, toy
from mjxwalk.cli import main
from mjxwalk.sweep import local
signal.signal(signal.SIGINT, signal.default_int_handler)
toy.install(pytest.MonkeyPatch())
local.PROGRAM = (sys.executable, {str(FAKE)!r})
sys.exit(main(["sweep", "toy", "--seeds", "2", "--set", "strategy.sigma=20", "--out", "s"]))
"""
    environment = {**os.environ, "PYTHONPATH": str(Path(toy.__file__).parent)}
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env=environment
    )
    figures = Path("s/seed-0/metrics.jsonl")
    deadline = time.monotonic() + 120
    while not figures.exists() and time.monotonic() < deadline:
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=120)
    assert process.returncode == 130
    assert "stopped with 0 of 2 runs finished; go on with: mjxwalk resume s" in out
    assert not folder.is_locked(Path("s/seed-0"))


def test_tensorboard_is_passed_on_also_to_runs_that_go_on() -> None:
    command = ["sweep", "toy", "--seeds", "1", "--set", "strategy.sigma=13", "--tensorboard"]
    assert main([*command, "--out", "s"]) == 2
    Path("mended").touch()
    assert main(["resume", "s"]) == 0
    begun, resumed = (each["args"] for each in told("seed-0"))
    assert parse("mjxwalk evolve", Evolve, begun[1:]).tensorboard
    assert resumed == ["resume", "s/seed-0", "--tensorboard"]


@pytest.mark.parametrize("flag", ["--live", "--tensorboard", "--distributed"])
def test_flags_of_one_run_are_refused_when_a_sweep_goes_on(
    flag: str, capsys: pytest.CaptureFixture[str]
) -> None:
    plan.create(Path("s"), make_plan(Evolve(experiment="toy"), 1, plan.Resources()))
    assert main(["resume", "s", flag]) == 2
    assert f"s is a sweep, whose runs go on as they were begun; {flag}" in capsys.readouterr().err


def test_of_two_processes_that_plan_at_once_the_second_reads_what_the_first_wrote(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first = make_plan(Evolve(experiment="toy"), 1, plan.Resources())
    second = make_plan(Evolve(experiment="toy"), 2, plan.Resources())
    locked = plan.locked

    @contextlib.contextmanager
    def slow(path: Path) -> Generator[None]:
        monkeypatch.setattr(plan, "locked", locked)
        plan.create(path, first)
        with locked(path):
            yield

    monkeypatch.setattr(plan, "locked", slow)
    with pytest.raises(RunError, match="holds another sweep"):
        plan.create(Path("s"), second)
    assert plan.read(Path("s"), is_of_sweep).runs == first.runs


def test_what_a_damaged_run_tells_is_nothing() -> None:
    Path("a").mkdir()
    assert run_progress.read(Path("a")) == run_progress.RunProgress()
    Path("a", config.FILE).write_text("{")
    assert run_progress.read(Path("a")) == run_progress.RunProgress(is_begun=True)


def test_one_process_at_a_time_makes_a_kernel(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    order: list[str] = []

    def second() -> None:
        with entries.alone("code", "abc"):
            order.append("second")

    other = threading.Thread(target=second)
    with entries.alone("code", "abc"):
        other.start()
        with entries.alone("code", "xyz"):
            pass
        time.sleep(0.2)
        order.append("first")
    other.join()
    assert order == ["first", "second"]
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with entries.alone("code", "abc"):  # no disk to tell by
        pass
