"""Kills runs at random instants, and compares what they resume to with a run that was left alone.

    python tests/robustness/killing.py 100

Each run is a process of its own, killed with SIGKILL and resumed until it ends; instants are drawn
over the time that it takes, from its first file to its last.
"""

import multiprocessing
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import jax
import numpy as np
import pytest
import toy

from mjxwalk import runs
from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.runs import config, folder, result

GENERATIONS = 30
SETTINGS = Config(experiment=toy.Toy(generations=GENERATIONS), seed=5, keep=2)


def go_on(path: Path) -> None:
    """Begins a run or goes on with it, as the command line does."""
    # What the processes before compiled: else compiling is nearly all that is ever killed.
    jax.config.update("jax_compilation_cache_dir", str(path.parent / "compiled"))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    if not (path / config.FILE).exists():
        run_config.create(path, SETTINGS)
    with folder.locked(path):
        settings = run_config.read(path)
        if result.read(path) is None:
            toy.evolve(path, settings)


def kill_until_it_ends(path: Path, random: np.random.Generator, most: int, span: float) -> int:
    """Takes a run to its end through kills, at most so many; returns how many there were.

    Args:
      path: of the run's folder.
      random: draws the instants.
      most: kills after which it is left alone.
      span: s; longest time until a kill.
    """
    # A process that forks before JAX has threads starts in milliseconds.
    context = multiprocessing.get_context("fork")
    for kills in range(most + 1):
        process = context.Process(target=go_on, args=(path,))
        process.start()
        assert process.pid is not None
        if kills < most:
            process.join(span * random.random())
            if process.is_alive():
                os.kill(process.pid, signal.SIGKILL)
        process.join()
        if process.exitcode == 0:
            return kills
        assert process.exitcode == -signal.SIGKILL, f"ended by itself with {process.exitcode}"
    raise AssertionError("it did not end although it was left alone")


def facts(path: Path) -> dict[str, object]:
    """Returns all of a finished run that does not tell how long it took."""
    run = runs.load(path)
    assert run.result is not None
    figures = {
        name: column.tobytes()
        for name, column in run.metrics.items()
        if name == "speed_m_s" or not name.endswith("_s")
    }
    arrays = {name: array.tobytes() for name, array in run.arrays.items()}
    champion = (path / "champion.npz").read_bytes()
    return {"arrays": arrays, "champion": champion, **figures, "result": run.result.champion}


def attack(number: int, seed: int, place: Path) -> tuple[int, list[int]]:
    """Returns how many kills there were, and how many generations each run had on disk by then.

    Raises:
      AssertionError: a run resumed to other bits, or could not be resumed.
    """
    random = np.random.default_rng(seed)
    context = multiprocessing.get_context("fork")
    span = 0.0
    for name in ("compiling", "whole"):
        alone = context.Process(target=go_on, args=(place / name,))
        started = time.monotonic()
        alone.start()
        alone.join()
        span = 0.7 * (time.monotonic() - started)
    whole = facts(place / "whole")
    kills: list[int] = []
    while sum(kills) < number:
        path = place / f"killed-{len(kills)}"
        kills.append(kill_until_it_ends(path, random, min(8, number - sum(kills)), span))
        assert facts(path) == whole, f"{path} resumed to other bits"
        span *= 1.0 if kills[-1] else 0.9
    return sum(kills), kills


def in_new_process(code: str) -> None:
    """Runs Python in a process of its own, which sees the tests' helpers."""
    here = Path(__file__).parent
    paths = os.pathsep.join([str(here), str(here.parent)])
    environment = {**os.environ, "PYTHONPATH": paths}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr


if __name__ == "__main__":
    toy.install(pytest.MonkeyPatch())
    with tempfile.TemporaryDirectory() as folder_of_all:
        total, kills_of_each = attack(int(sys.argv[1]), seed=0, place=Path(folder_of_all))
    runs_of_all = len(kills_of_each)
    print(f"{total} kills of {runs_of_all} runs; every one resumed to the same bits")
