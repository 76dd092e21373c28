"""Tests of what runs the runs of a sweep, and of what ends them."""

import json
import os
import sys
import time
import types
from pathlib import Path
from typing import Any

import pytest
import toy

from mjxwalk.cli import main
from mjxwalk.cli.evolve import Evolve
from mjxwalk.cli.sweep_grid import make_plan
from mjxwalk.sweep import jobs, local, on_ray, plan, worker
from mjxwalk.sweep.jobs import Job
from mjxwalk.sweep.local import Local

FAKE = Path(__file__).with_name("fake.py")
LOG = Path("s/logs/seed-0.log")


@pytest.fixture(autouse=True)
def in_new_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(local, "PROGRAM", (sys.executable, str(FAKE)))


def told(name: str, place: str = "s") -> list[dict[str, Any]]:
    """Returns what the process of each start of a run said of itself."""
    lines = Path(place, "logs", f"{name}.log").read_text().splitlines()
    return [json.loads(line) for line in lines if line.startswith("{")]


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="cores cannot be chosen here")
def test_each_run_has_cores_and_memory_of_its_own() -> None:
    cores = sorted(os.sched_getaffinity(0))
    limits = ["--cores-per-run", "1", "--memory-per-run", "2.5"]
    assert main(["sweep", "toy", "--seeds", "2", *limits, "--out", "s"]) == 0
    for name in ("seed-0", "seed-1"):
        (said,) = told(name)
        assert (len(said["cores"]), said["threads"], said["memory"]) == (1, "1", 2_500_000_000)
    if len(cores) > 1:
        assert told("seed-0")[0]["cores"] != told("seed-1")[0]["cores"]
    assert sorted(os.sched_getaffinity(0)) == cores
    assert main(["sweep", "toy", "--seeds", "1", "--out", "alone"]) == 0
    assert told("seed-0", "alone")[0]["cores"] == cores


def test_a_killed_run_is_said_to_be_killed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", "toy", "--seeds", "1", "--set", "strategy.sigma=9", "--out", "s"]) == 2
    error = capsys.readouterr().err
    assert "seed-0: it was ended by signal 9 (SIGKILL), as the system does where memory" in error


def test_a_run_that_a_killed_sweep_left_over_is_waited_for() -> None:
    planned = make_plan(Evolve(experiment="toy"), 1, plan.Resources())
    plan.create(Path("s"), planned)
    Path("s/logs").mkdir()
    job = Job("seed-0", ("evolve", "toy", "--out", "s/seed-0"), Path("s/seed-0"), LOG)
    code = f"import time; time.sleep(2); exec(open({str(FAKE)!r}).read())"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(local, "PROGRAM", (sys.executable, "-c", code))
        left = Local(plan.Resources(), 1).start(job)
    assert left is not None and not Path("s/seed-0").exists()  # not even its folder is locked yet
    assert Local(plan.Resources(), 1).start(job) is None
    assert main(["resume", "s"]) == 0
    assert left.is_done()
    assert [each["args"][0] for each in told("seed-0")] == ["evolve", "resume"]


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="the system does not tell")
def test_a_clusters_process_gets_the_memory_of_a_run_on_top_of_what_it_has(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    limits: list[float] = []
    monkeypatch.setattr(jobs, "limit_memory", lambda _, most: limits.append(most))
    monkeypatch.setattr(jobs, "THREADS", "MJXWALK_TESTS_THREADS")
    taken = bytes(300_000_000)
    Path("logs").mkdir()
    assert worker.work(main, ["evolve", "--nonsense"], "s", "logs/s.log", 1, 0.5) == 2
    assert limits[0] > 0.5 + len(taken) / jobs.GIGABYTE
    assert "unrecognized options" in Path("logs/s.log").read_text()


def test_a_run_that_cannot_be_started_is_told_of(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(local, "PROGRAM", ("/nowhere/python",))
    assert main(["sweep", "toy", "--seeds", "2", "--out", "s"]) == 2
    captured = capsys.readouterr()
    assert "2 failed" in captured.out
    assert "it could not be started: no such file or directory" in captured.err


def test_a_ray_cluster_that_does_not_answer_is_told_of_soon(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "ray", types.ModuleType("ray"))
    monkeypatch.setattr(on_ray, "WAITING", 0.5)
    monkeypatch.setattr(on_ray, "TRY", "import time; time.sleep(60)")
    began = time.monotonic()
    command = ["sweep", "toy", "--executor", "ray", "--address", "10.0.0.1:1", "--out", "s"]
    assert main(command) == 2
    assert time.monotonic() - began < 30
    assert "no Ray cluster answers at 10.0.0.1:1 (no answer in 0 s)" in capsys.readouterr().err
    monkeypatch.setattr(on_ray, "TRY", "raise ConnectionError('nobody is there')")
    assert main(command) == 2
    assert "(ConnectionError: nobody is there)" in capsys.readouterr().err


def test_slurm_is_refused_where_there_is_no_sbatch(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "submitit", types.ModuleType("submitit"))
    monkeypatch.setenv("PATH", "")
    assert main(["sweep", "toy", "--executor", "slurm", "--out", "s"]) == 2
    error = capsys.readouterr().err
    assert (
        error == "mjxwalk: there is no `sbatch` here; give the command where jobs are submitted\n"
    )
