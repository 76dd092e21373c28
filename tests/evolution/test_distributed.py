"""Tests of runs that several processes share, over loopback."""

import signal
import socket
import subprocess
from pathlib import Path

import pytest
import toy
from terminal import start, wait_for_lines

from mjxwalk import runs
from mjxwalk.cli import main


@pytest.fixture(autouse=True)
def in_new_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)


def start_together(number: int, *args: str) -> list[subprocess.Popen[str]]:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{free.getsockname()[1]}"
    together = ["--distributed", "--coordinator", address, "--processes", str(number)]
    return [start(*args, *together, "--process", str(place)) for place in range(number)]


def end(processes: list[subprocess.Popen[str]]) -> list[tuple[int, str, str]]:
    said = [process.communicate(timeout=300) for process in processes]
    return [(p.returncode, *each) for p, each in zip(processes, said, strict=True)]


def same_run(one: str, other: str) -> bool:
    a, b = runs.load(one), runs.load(other)
    assert a.result is not None and b.result is not None
    return (
        {n: v.tobytes() for n, v in a.arrays.items()}
        == {n: v.tobytes() for n, v in b.arrays.items()}
        and a.result.champion == b.result.champion
        and Path(one, "champion.npz").read_bytes() == Path(other, "champion.npz").read_bytes()
    )


@pytest.mark.slow
def test_two_processes_evolve_what_one_does_and_another_number_goes_on() -> None:
    settings = ["--generations", "12", "--population", "15"]  # which two do not share evenly
    assert main(["evolve", "toy", *settings, "--out", "one"]) == 0
    ended = end(start_together(2, "evolve", "toy", *settings, "--out", "two"))
    assert [code for code, _, _ in ended] == [0, 0], ended
    assert same_run("one", "two")
    assert runs.load("two").manifest["devices"] == "2 processes with 1 x cpu each"


@pytest.mark.slow
def test_two_processes_grow_a_population_as_one_does() -> None:
    grown = ["--set", "growth.interactions=2000", "--set", "growth.part=6", "--population", "18"]
    settings = ["--strategy", "pgpe", "--set", "strategy.sigma=0.3", *grown]
    assert main(["evolve", "toy", *settings, "--out", "one"]) == 0
    ended = end(start_together(2, "evolve", "toy", *settings, "--out", "two"))
    assert [code for code, _, _ in ended] == [0, 0], ended
    assert same_run("one", "two")
    assert runs.load("two").metrics["strategy.num_evaluated"].tolist() == [12] * 6


@pytest.mark.slow
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("receiver", [0, 1])
def test_a_signal_to_one_process_saves_and_ends_all(sent: signal.Signals, receiver: int) -> None:
    settings = ["--generations", "12", "--population", "15"]
    assert main(["evolve", "toy", *settings, "--out", "one"]) == 0
    slow = [*settings, "--set", "env.delay_s=0.3"]
    processes = start_together(2, "evolve", "toy", *slow, "--out", "three")
    wait_for_lines(Path("three/metrics.jsonl"), 3)
    processes[receiver].send_signal(sent)
    ended = end(processes)
    codes = [128 + signal.SIGINT] * 2
    codes[receiver] = 128 + sent
    assert [code for code, _, _ in ended] == codes, ended
    assert runs.load("three").generation < 12
    assert main(["resume", "three"]) == 0
    assert same_run("one", "three")


def test_sigterm_saves_and_ends_a_distributed_run() -> None:
    slow = ["--generations", "200", "--set", "env.delay_s=0.05"]
    processes = start_together(1, "evolve", "toy", *slow, "--out", "a")
    wait_for_lines(Path("a/metrics.jsonl"), 2)
    processes[0].terminate()
    ((code, said, _),) = end(processes)
    assert code == 128 + signal.SIGTERM
    assert "go on with: mjxwalk resume a" in said
    assert 2 <= runs.load("a").generation < 200


@pytest.mark.slow
def test_a_process_that_dies_ends_the_run_with_a_sentence() -> None:
    slow = ["--generations", "200", "--set", "env.delay_s=0.2"]
    processes = start_together(2, "evolve", "toy", *slow, "--out", "a")
    wait_for_lines(Path("a/metrics.jsonl"), 3)
    processes[1].kill()
    code, _, error = end(processes)[0]
    assert code == 2
    assert "another process of this run ended or cannot be reached" in error
    assert "Traceback" not in error
    assert runs.load("a").generation >= 2


@pytest.mark.slow
def test_processes_that_were_told_different_things_are_refused() -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{free.getsockname()[1]}"
    together = ["--distributed", "--coordinator", address, "--processes", "2"]
    ended = end(
        [
            start("evolve", "toy", "--seed", str(n), *together, "--process", str(n), "--out", "a")
            for n in range(2)
        ]
    )
    assert [code for code, _, _ in ended] == [2, 2]
    assert "were given different settings" in ended[0][2]
    assert not Path("a").exists()
