"""Tests that the shell a command is started from changes nothing of what comes out."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import msgspec
import pytest
import toy

from mjxwalk import runs
from mjxwalk.cli import process
from mjxwalk.runs.result import npz

TOY = (sys.executable, toy.__file__)
MJXWALK = (sys.executable, "-m", "mjxwalk")
SMALL = ("evolve", "--population", "16", "--generations", "2")

# Each changed the numbers of a run, or stopped it.
COMPUTING = {
    "JAX_ENABLE_X64": "1",
    "JAX_THREEFRY_PARTITIONABLE": "0",
    "JAX_DEFAULT_PRNG_IMPL": "rbg",
    "JAX_RANDOM_SEED_OFFSET": "5",
    "JAX_NUMPY_DTYPE_PROMOTION": "strict",
    "JAX_NUMPY_RANK_PROMOTION": "raise",
    "JAX_DEFAULT_MATMUL_PRECISION": "bfloat16",
    "JAX_TRANSFER_GUARD": "disallow",
    "JAX_NO_TRACING": "1",
    "JAX_ENABLE_CHECKS": "maybe",
    "XLA_FLAGS": "--xla_cpu_enable_fast_math=true --xla_no_such_flag=1",
}
SPEAKING: dict[str, dict[str, str]] = {
    "ASCII": {"PYTHONIOENCODING": "ascii"},
    "C locale": {"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "LC_ALL": "C"},
    "no locale": {"LC_ALL": "nonsense"},
    "warnings": {"PYTHONWARNINGS": "error"},
    "optimised": {"PYTHONOPTIMIZE": "2"},
    "narrow": {"COLUMNS": "0", "TERM": "nonsense"},
    "no TMPDIR": {"TMPDIR": "/dev/null/none"},
    "time zone": {"TZ": "Nonsense/Zone"},
}


def start(
    command: tuple[str, ...], folder: Path, shell: str = "", **variables: str
) -> subprocess.CompletedProcess[bytes]:
    """Returns how a command ended.

    Args:
      command: words.
      folder: to work in.
      shell: what a shell would read behind the words, such as where their output goes.
      variables: of the environment.
    """
    through = ("bash", "-c", f'exec "$@" {shell}', "bash") if shell else ()
    return subprocess.run(
        [*through, *command],
        cwd=folder,
        env=os.environ | variables,
        capture_output=True,
        timeout=300,
    )


def bits(path: Path) -> tuple[Any, bytes]:
    """Returns a run's figures without its times, and its champion."""
    run = runs.load(path)
    figures = {
        name: value.tolist()
        for name, value in run.metrics.items()
        if not name.endswith("_s") and name != "steps_per_s" or name == "speed_m_s"
    }
    return figures, npz(run.champion)


def evolve(folder: Path, *, shell: str = "", **variables: str) -> tuple[Any, bytes]:
    """Returns the bits of a small run of the real thing."""
    words = (*MJXWALK, *SMALL, "--set", "env.max_time=0.5", "--out", "run")
    ended = start(words, folder, shell, **variables)
    assert ended.returncode == 0, ended.stderr.decode()
    return bits(folder / "run")


@pytest.fixture(scope="module")
def usual(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, bytes]:
    """Returns the bits of a run that nothing ambient was set for."""
    return evolve(tmp_path_factory.mktemp("usual"))


def test_no_setting_of_jax_in_the_environment_changes_a_run(
    tmp_path: Path, usual: tuple[Any, bytes]
) -> None:
    assert evolve(tmp_path, **COMPUTING) == usual
    manifest = msgspec.json.decode((tmp_path / "run" / "manifest.json").read_bytes())
    assert manifest["settings"]["jax_enable_x64"] is False
    assert manifest["settings"]["jax_random_seed_offset"] == 0
    assert manifest["settings"]["XLA_FLAGS"] is None


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(COMPUTING))
def test_no_single_setting_of_jax_changes_a_run(
    name: str, tmp_path: Path, usual: tuple[Any, bytes]
) -> None:
    assert evolve(tmp_path, **{name: COMPUTING[name]}) == usual


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(SPEAKING))
def test_no_setting_of_python_or_the_terminal_changes_a_run(
    name: str, tmp_path: Path, usual: tuple[Any, bytes]
) -> None:
    assert evolve(tmp_path, **SPEAKING[name]) == usual


@pytest.mark.slow
@pytest.mark.parametrize("shell", [">&-", "2>&-", "<&-", ">&- 2>&- <&-"])
def test_closed_streams_change_nothing_of_a_run(
    shell: str, tmp_path: Path, usual: tuple[Any, bytes]
) -> None:
    assert evolve(tmp_path, shell=shell) == usual


def test_what_is_left_out_of_account_is_told_in_one_sentence(tmp_path: Path) -> None:
    ended = start((*MJXWALK, "list"), tmp_path, JAX_ENABLE_X64="1", XLA_FLAGS="--x")
    assert ended.returncode == 0
    assert ended.stderr.startswith(b"mjxwalk: JAX_ENABLE_X64, XLA_FLAGS left out of account")
    assert ended.stderr.count(b"\n") == 1


def test_every_option_of_jax_is_left_out_but_those_of_where_it_computes() -> None:
    import jax

    names = {name.upper() for name in jax.config.values}
    kept = {name for name in names if not process.is_left_out(name)}
    assert kept == {
        "JAX_PLATFORMS",
        "JAX_PLATFORM_NAME",
        "JAX_CUDA_VISIBLE_DEVICES",
        "JAX_ROCM_VISIBLE_DEVICES",
        "JAX_COMPILATION_CACHE_DIR",
        "JAX_DUMP_IR_TO",
    }


@pytest.mark.parametrize("shell", [">&-", "2>&-", "<&-", ">&- 2>&- <&-"])
def test_a_closed_stream_is_no_fault(shell: str, tmp_path: Path) -> None:
    ended = start((*TOY, *SMALL, "--out", "run"), tmp_path, shell)
    assert (ended.returncode, ended.stderr) == (0, b"")
    assert runs.load(tmp_path / "run").result is not None


def test_files_never_get_the_number_of_a_closed_stream(tmp_path: Path) -> None:
    code = "import os; from mjxwalk.cli import process; process.own(); print(os.open('f', 65))"
    ended = start((sys.executable, "-c", code), tmp_path, "2>&- <&-")
    assert int(ended.stdout) > 2


@pytest.mark.parametrize("args", [("list",), ("--help",), ("evolve", "--help")])
def test_a_full_disk_under_the_output_is_one_sentence(
    args: tuple[str, ...], tmp_path: Path
) -> None:
    ended = start((*MJXWALK, *args), tmp_path, ">/dev/full")
    assert ended.returncode == 2
    assert ended.stderr == b"mjxwalk: the output cannot be used: no space left on device\n"


@pytest.mark.parametrize("args", [("list",), ("--help",), ("evolve", "--help")])
def test_a_reader_that_has_had_enough_is_no_news(args: tuple[str, ...], tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    started = subprocess.Popen(
        [*MJXWALK, *args], cwd=tmp_path, stdout=writer, stderr=subprocess.PIPE
    )
    os.close(writer)
    _, error = started.communicate(timeout=100)
    assert (started.returncode, error) == (128 + signal.SIGPIPE, b"")


@pytest.mark.parametrize("name", sorted(SPEAKING))
def test_every_list_is_printed_whatever_the_terminal(name: str, tmp_path: Path) -> None:
    ended = start((*MJXWALK, "list"), tmp_path, **SPEAKING[name])
    assert (ended.returncode, ended.stderr) == (0, b"")


@pytest.mark.parametrize("columns", ["0", "1", "3", "x"])
def test_a_complaint_is_the_same_sentence_however_narrow_the_terminal(
    columns: str, tmp_path: Path
) -> None:
    words = (*MJXWALK, "evolve", "--seed", "seven")
    assert start(words, tmp_path, COLUMNS=columns).stderr == start(words, tmp_path).stderr


def test_a_name_that_is_no_text_can_be_told(tmp_path: Path) -> None:
    ended = start((*MJXWALK, "list", "--runs", "a\udcff\u00e9"), tmp_path, PYTHONIOENCODING="ascii")
    assert ended.returncode == 0
    assert rb"No runs in a\udcff\xe9" in ended.stdout


IMPORTING = """
import dataclasses, sys
from mjxwalk import cli

@dataclasses.dataclass(frozen=True, kw_only=True)
class Command:
    \"\"\"Import.\"\"\"

    def run(self) -> int:
        import slow
        return 0

sys.exit(cli.run("import", Command))
"""
SLOW = """
import time
print("importing", flush=True)
try:
    time.sleep(60)
except BaseException:
    raise ImportError("as libraries in C make of any exception") from None
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_importing_ends_the_process_without_a_traceback(
    number: signal.Signals, tmp_path: Path
) -> None:
    (tmp_path / "slow.py").write_text(SLOW, encoding="utf-8")
    (tmp_path / "importing.py").write_text(IMPORTING, encoding="utf-8")
    with subprocess.Popen(
        [sys.executable, "importing.py"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as started:
        assert started.stdout is not None
        assert started.stdout.readline() == b"importing\n"
        started.send_signal(number)
        _, error = started.communicate(timeout=60)
    assert (started.returncode, error) == (128 + number, b"")


def test_a_platform_that_is_not_there_is_one_sentence(tmp_path: Path) -> None:
    ended = start((*MJXWALK, *SMALL, "--out", "run"), tmp_path, JAX_PLATFORMS="nonsense")
    assert ended.returncode == 2
    assert ended.stderr.startswith(b"mjxwalk: JAX does not start on 'nonsense'")
    assert ended.stderr.count(b"\n") == 1
    assert not (tmp_path / "run").exists()


def test_doctor_tells_a_platform_that_is_not_there_and_misses_nothing(tmp_path: Path) -> None:
    ended = start((*MJXWALK, "doctor"), tmp_path, JAX_PLATFORMS="nonsense")
    assert ended.returncode == 1
    assert b"JAX does not start on 'nonsense', which JAX_PLATFORMS asks for" in ended.stdout
    assert b"missing" not in ended.stdout


@pytest.mark.parametrize("name", ["nonsense", "osmesa"])
def test_physics_needs_no_opengl(name: str, tmp_path: Path) -> None:
    code = "from mjxwalk.envs._mujoco import mujoco; mujoco.MjModel.from_xml_string('<mujoco/>')"
    assert start((sys.executable, "-c", code), tmp_path, MUJOCO_GL=name).returncode == 0


def test_too_few_addresses_for_jax_are_told_before_it_aborts(tmp_path: Path) -> None:
    words = ("bash", "-c", 'ulimit -v 1000000; exec "$@"', "bash", *MJXWALK, "list")
    ended = start(words, tmp_path)
    assert ended.returncode == 2
    assert ended.stderr.startswith(b"mjxwalk: `ulimit -v` leaves 1 GB of addresses")


def test_a_folder_that_is_gone_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "gone").mkdir()
    words = ("bash", "-c", 'rmdir ../gone; exec "$@"', "bash", *MJXWALK, "report", "run")
    ended = start(words, tmp_path / "gone")
    assert ended.returncode == 2
    assert ended.stderr.count(b"\n") == 1 and ended.stderr.startswith(b"mjxwalk: ")


def test_a_number_of_threads_that_is_none_is_one_sentence(tmp_path: Path) -> None:
    words = (*MJXWALK, *SMALL, "--out", "run")
    ended = start(words, tmp_path, MJXWALK_LANES_THREADS="two")
    assert ended.returncode == 2
    assert ended.stderr == b"mjxwalk: MJXWALK_LANES_THREADS must be a whole number, got 'two'\n"
