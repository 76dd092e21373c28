"""A run's folder while a process works on it: made once, locked, its checkpoints in step."""

import datetime
import itertools
from pathlib import Path

import msgspec

from mjxwalk import shell
from mjxwalk.errors import RunError
from mjxwalk.runs import config, files, inheritance, study, task_file
from mjxwalk.runs.config import ConfigFile
from mjxwalk.runs.inheritance import Inherited
from mjxwalk.runs.locking import CHECKPOINTS, LOCK_FILE, check_links, is_locked, locked

RUNS = Path("runs")
ZOO = "zoo:"  # begins the name of a walker that ships
# What a process that was killed while it made a run's folder may have left in it.
WRITTEN_BEFORE = (inheritance.FILE, task_file.FILE)
BEGUN = (
    LOCK_FILE,
    *WRITTEN_BEFORE,
    *(files.partial(name) for name in (*WRITTEN_BEFORE, config.FILE)),
)


def default_path(experiment: str, seed: int) -> Path:
    """Returns a new folder's path: runs/<experiment>-<seed>-<time>, with a number if it is there.

    A clock that is put back tells a time again.
    """
    now = datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    path = RUNS / f"{experiment.replace('/', '-')}-{seed}-{now}"
    numbered = (path.with_name(f"{path.name}-{number}") for number in itertools.count(2))
    return next(each for each in itertools.chain([path], numbered) if not each.exists())


def check_name(path: Path) -> None:
    """Raises RunError if commands would take a folder's name for a walker that ships."""
    if str(path).startswith(ZOO):
        raise RunError(
            f"--out {path} would be taken for a walker that ships, as its name begins with {ZOO}; "
            "choose another"
        )


def check_free(path: Path) -> None:
    """Returns if a run may start in a folder.

    Raises:
      RunError: it holds a run or anything else, or is no folder.
    """
    check_name(path)
    if (path / config.FILE).exists() or study.is_study(path):
        kind = "study" if study.is_study(path) else "run"
        raise RunError(
            f"{path} already holds a {kind}; continue it with `{shell.command('resume', path)}` or "
            "choose another --out"
        )
    if path.exists() and (
        not path.is_dir() or any(each.name not in BEGUN for each in path.iterdir())
    ):
        raise RunError(f"{path} exists and is not an empty folder; choose another --out")


def create(
    path: Path, settings: ConfigFile, inherited: Inherited | None, task: bytes | None = None
) -> None:
    """Makes a run's folder with its `config.json`.

    Args:
      path: of the folder.
      settings: of the run.
      inherited: what it starts from; None for zero.
      task: text of a user's own task; None of our own experiments.

    Raises:
      RunError: the folder is taken, or a file cannot be written.
    """
    check_free(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{path} could not be made: {files.describe(error)}") from error
    with locked(path):
        check_free(path)  # again: another process may have been as quick
        digest = None if inherited is None else inheritance.write(path, inherited)
        if task is not None:
            task_file.write(path, task)
        # Last: with it the folder holds a run.
        config.write(path, msgspec.structs.replace(settings, start=digest))


def check_run(path: Path) -> None:
    """Returns if a folder holds a run.

    Raises:
      RunError: it does not.
    """
    if not path.exists() and str(path).startswith(ZOO):
        raise RunError(f"{path} is one walker without a run; name a run's folder")
    if not path.exists():
        raise RunError(f"{path} does not exist; `mjxwalk list` shows the runs in ./{RUNS}")
    if study.is_study(path):
        inside = sorted(str(file.parent) for file in path.glob(f"*/{config.FILE}"))
        which = f"; name one of its runs: {', '.join(inside)}" if inside else ""
        raise RunError(f"{path} is a study, not a run{which}")
    if not (path / config.FILE).is_file():
        raise RunError(f"{path} is no run: it has no {config.FILE}")
    check_links(path)


__all__ = [
    "CHECKPOINTS",
    "RUNS",
    "check_free",
    "check_name",
    "check_run",
    "create",
    "default_path",
    "is_locked",
    "locked",
]
