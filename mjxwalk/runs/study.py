"""A study on disk: a folder with `study.json` and one run's folder for each phase."""

from pathlib import Path
from typing import Any

import msgspec

from mjxwalk import shell
from mjxwalk.errors import RunError
from mjxwalk.runs import digests, files
from mjxwalk.runs.locking import LOCK_FILE, locked

FILE = "study.json"
SCHEMA = 2  # of this file; raise it when a setting changes its meaning
WITHOUT_DIGEST = 1  # the version before, which had no digest and is read as well
# What a process that was killed while it made a study's folder may have left in it.
BEGUN = (LOCK_FILE, files.partial(FILE))


class PhaseFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A phase in `study.json`: its name, and the settings of its experiment."""

    name: str
    experiment: dict[str, Any]


class StudyFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The content of `study.json`; `StudyConfig` tells what each part is."""

    schema: int
    digest: str | None = None
    name: str
    seed: int
    engine: str
    keep: int | None
    save_every: int
    scale: float
    phases: list[PhaseFile]


def is_study(path: Path) -> bool:
    """Returns whether a folder holds a study."""
    return (path / FILE).is_file()


def check_free(path: Path) -> None:
    """Returns if a study may start in a folder.

    Raises:
      RunError: it holds anything, or is no folder.
    """
    if is_study(path):
        raise RunError(
            f"{path} already holds a study; continue it with `{shell.command('resume', path)}` or "
            "choose another --out"
        )
    if path.exists() and (
        not path.is_dir() or any(each.name not in BEGUN for each in path.iterdir())
    ):
        raise RunError(f"{path} exists and is not an empty folder; choose another --out")


def create(path: Path, file: StudyFile) -> None:
    """Makes a study's folder with its `study.json`.

    Raises:
      RunError: the folder is taken, or cannot be made.
    """
    check_free(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{path} could not be made: {files.describe(error)}") from error
    with locked(path):
        check_free(path)  # again: another process may have been as quick
        files.replace(path, FILE, text(file))


def text(file: StudyFile) -> bytes:
    """Returns the content of `study.json`, with its digest."""
    return digests.with_digest(file)


def read(path: Path) -> tuple[StudyFile, bytes]:
    """Returns `study.json` as it was found, which `check` must follow, and its bytes.

    Raises:
      RunError: the folder holds none, or the file is not what a study writes.
    """
    file = path / FILE
    raw = files.read_inside(path, FILE, files.MOST_JSON)
    if raw is None:
        raise RunError(f"{path} is no study: it has no {FILE}")
    schema = files.decode_table(file, raw).get("schema")
    if isinstance(schema, int) and schema not in (WITHOUT_DIGEST, SCHEMA):
        raise RunError(f"{file} has version {schema} and this mjxwalk reads version {SCHEMA}")
    return files.decode(file, raw, StudyFile), raw


def check(path: Path, file: StudyFile, content: bytes) -> None:
    """Raises RunError unless `study.json` is as it was written."""
    if file.schema != WITHOUT_DIGEST or file.digest is not None:
        digests.check(path / FILE, content, needed=True)
