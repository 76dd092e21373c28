"""Tests of numbers that no setting or argument can have: one sentence, at once, nothing made."""

import dataclasses
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from mjxwalk import experiments
from mjxwalk.cli import main
from mjxwalk.cli.choosing import choose_run
from mjxwalk.cli.evolve import Evolve
from mjxwalk.errors import RunError
from mjxwalk.settings import override

NO_NUMBERS = ("nan", "inf", "-inf", "1e308", "-1e308", "1e999", "9223372036854775808", "1" * 5000)
WRONG_FOR_MOST = ("-1", "0", "1e9", "2000000000", "1e-300", "null", "true", "[]", '"x"')


def numeric(settings: Any, path: str = "") -> Iterator[str]:
    """Yields the paths of all settings that are numbers."""
    for field in dataclasses.fields(settings):
        value, here = getattr(settings, field.name), f"{path}{field.name}"
        if dataclasses.is_dataclass(value):
            yield from numeric(value, f"{here}.")
        elif field.name == "options":
            yield from (f"{path}{name}" for name in value)
        elif isinstance(value, int | float) or value is None:
            yield here


def every() -> list[tuple[str, str]]:
    """Returns an experiment and a path for each numeric setting that any experiment has."""
    found: dict[tuple[str, ...], tuple[str, str]] = {}
    for name in experiments.names():
        experiment = experiments.get(name)
        for path in numeric(experiment):
            group: Any = experiment
            for part in path.split(".")[:-1]:
                group = getattr(group, part)
            kind = type(group).__name__, path, getattr(group, "name", "")
            found.setdefault(kind, (name, path))
    return sorted(found.values())


EVERY = every()


def test_there_are_settings_to_try() -> None:
    paths = {path for _, path in EVERY}
    assert len(EVERY) > 100
    assert {"population_size", "env.timestep", "goal.trials", "strategy.sigma"} <= paths
    assert {"env.terrain.length", "network.num_harmonics", "pruning.reference"} <= paths


@pytest.mark.parametrize("value", NO_NUMBERS, ids=lambda value: value[:20])
def test_no_setting_takes_what_is_no_number_to_compute_with(value: str) -> None:
    for name, path in EVERY:
        with pytest.raises(RunError, match=re.escape(path.rpartition(".")[2])):
            override(experiments.get(name), path, value)


def choose(name: str, path: str, value: str) -> str:
    """Returns the sentence with which a run is refused, "" if it is not."""
    try:
        choose_run(Evolve(experiment=name, set=(f"{path}={value}",)))
    except RunError as error:
        return str(error)
    return ""


@pytest.mark.slow
@pytest.mark.parametrize("value", WRONG_FOR_MOST)
def test_every_setting_is_taken_or_refused_in_a_sentence(value: str) -> None:
    refused = [choose(name, path, value) for name, path in EVERY]
    assert sum(map(bool, refused)) > len(EVERY) / 4


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("population_size", "2000000000"),
        ("terrains_per_evaluation", "10000000"),
        ("goal.trials", "1000000000"),
        ("goal.fine_trials", "1000000000"),
        ("goal.fine_factor", "1000000"),
        ("env.terrain.length", "3e7"),
        ("env.terrain.spacing", "1e-6"),
        ("env.timestep", "1e-300"),
        ("env.timestep", "1e-6"),
        ("env.timestep", "61"),
        ("env.max_time", "1e9"),
        ("env.torso_mass", "1e-300"),
    ],
)
def test_what_would_take_for_ever_or_all_memory_is_refused_at_once(path: str, value: str) -> None:
    experiments.get("planar-lpd").template()  # JAX's first array
    started = time.perf_counter()
    assert choose("planar-lpd", path, value)
    assert time.perf_counter() - started < 3.0


@pytest.mark.parametrize(
    "args",
    [
        ["--population", "9223372036854775808"],
        ["--terrains", "10000000"],
        ["--generations", "100000000000000000000"],
        ["--keep", "100000000000000000000"],
        ["--save-every", "100000000000000000000"],
        ["--scale", "1e300"],
        ["--seed", "4294967296"],
        ["--roughness", "1e300"],
        ["solomon-2d", "--terrains", "100000000"],
        ["rayleigh-harmonic", "--set", "network.num_harmonics=1000000000"],
        ["rayleigh", "--set", "cycles=1000000000"],
    ],
)
def test_an_argument_beyond_measure_is_one_sentence_and_leaves_nothing(
    args: list[str],
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["evolve", *args, "--out", "run"]) == 2
    assert re.fullmatch(r"mjxwalk: [^\n]+\n", capfd.readouterr().err)
    assert not list(tmp_path.iterdir())


def run_limited(tmp_path: Path, gigabytes: int, code: str) -> subprocess.CompletedProcess[str]:
    """Returns a Python program that ran with so much memory."""
    # Not by preexec_fn: JAX's threads forbid what Python does between fork and exec.
    limit = f"import resource\nresource.setrlimit(resource.RLIMIT_AS, ({gigabytes << 30},) * 2)\n"
    return subprocess.run(
        [sys.executable, "-c", limit + code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize(
    "body",
    [
        "import numpy; numpy.ones(1 << 40)",
        "import jax; jax.numpy.ones(1 << 40) + 1",
        "raise MemoryError",
        "int(1e308) * 1.5 * float(10**309)",
    ],
)
def test_memory_that_runs_out_all_the_same_is_one_sentence(tmp_path: Path, body: str) -> None:
    code = f"""
import dataclasses, sys
from mjxwalk.cli import run
@dataclasses.dataclass(frozen=True, kw_only=True)
class Asking:
    def run(self):
        {body}
sys.exit(run("mjxwalk ask", Asking, []))
"""
    ran = run_limited(tmp_path, 8, code)
    assert ran.returncode == 2
    assert re.fullmatch(r"mjxwalk: [^\n]+\n", ran.stderr)


def test_an_error_of_another_kind_is_no_sentence(tmp_path: Path) -> None:
    code = """
import dataclasses, sys
from mjxwalk.cli import run
@dataclasses.dataclass(frozen=True, kw_only=True)
class Failing:
    def run(self):
        raise KeyError("a fault of ours")
sys.exit(run("mjxwalk fail", Failing, []))
"""
    ran = run_limited(tmp_path, 8, code)
    assert ran.returncode == 1
    assert "Traceback" in ran.stderr


def test_the_memory_that_a_process_may_take_counts(tmp_path: Path) -> None:
    code = "from mjxwalk import budget; print(budget.available())"
    assert int(run_limited(tmp_path, 3, code).stdout) <= 3 << 30
