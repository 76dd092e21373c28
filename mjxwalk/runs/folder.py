"""A run's folder while a process works on it: made once, locked, its checkpoints in step."""

import contextlib
import datetime
import fcntl
import os
from collections.abc import Generator
from pathlib import Path

from mjxwalk.errors import RunError
from mjxwalk.runs import config, files
from mjxwalk.runs.config import Config

CHECKPOINTS = "checkpoints"
LOCK_FILE = ".lock"
RUNS = Path("runs")


def default_path(experiment: str, seed: int) -> Path:
    """Returns a new folder's path: runs/<experiment>-<seed>-<time>."""
    now = datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    return RUNS / f"{experiment}-{seed}-{now}"


def check_free(path: Path) -> None:
    """Returns if a run may start in a folder.

    Raises:
      RunError: it holds a run or anything else, or is no folder.
    """
    if (path / config.FILE).exists():
        raise RunError(
            f"{path} already holds a run; continue it with `mjxwalk resume {path}` or choose "
            "another --out"
        )
    if path.exists() and (not path.is_dir() or any(path.iterdir())):
        raise RunError(f"{path} exists and is not an empty folder; choose another --out")


def create(path: Path, settings: Config) -> None:
    """Makes a run's folder with its `config.json`.

    Raises:
      RunError: the folder is taken, cannot be made, or the settings would not read back.
    """
    check_free(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{path} could not be made: {files.describe(error)}") from error
    config.write(path, settings)


def check_run(path: Path) -> None:
    """Returns if a folder holds a run.

    Raises:
      RunError: it does not.
    """
    if not path.exists():
        raise RunError(f"{path} does not exist; `mjxwalk list` shows the runs in ./{RUNS}")
    if not (path / config.FILE).is_file():
        raise RunError(f"{path} is no run: it has no {config.FILE}")


@contextlib.contextmanager
def locked(path: Path) -> Generator[None]:
    """Keeps other processes from working on the run, until the block ends or this process does.

    Raises:
      RunError: another process has it, or the folder cannot be written.
    """
    try:
        # The file stays: removing it would let a third process lock a new one beside a second.
        descriptor = os.open(path / LOCK_FILE, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        raise RunError(f"{path} cannot be written: {files.describe(error)}") from error
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise RunError(f"another process is working on {path}; wait for it to end") from None
        yield
    finally:
        os.close(descriptor)


def is_locked(path: Path) -> bool:
    """Returns whether a process is working on the run."""
    try:
        descriptor = os.open(path / LOCK_FILE, os.O_RDWR)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(descriptor)
    return False
