"""Small files of a run: replaced whole, appended by the line, with errors in words."""

import os
from pathlib import Path
from typing import TypeVar

import msgspec

from mjxwalk.errors import RunError

T = TypeVar("T")


def replace(path: Path, content: bytes) -> None:
    """Writes a file so that a reader finds the old content or the new, never a part.

    Raises:
      RunError: the disk is full, or the folder cannot be written.
    """
    unfinished = path.with_name(partial(path.name))
    try:
        with unfinished.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        unfinished.replace(path)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise RunError(f"{path} could not be written: {describe(error)}") from error


def partial(name: str) -> str:
    """Returns what a file is called while its content is being written."""
    return f".{name}.partial"


def append_line(path: Path, line: bytes) -> None:
    """Adds a line to a file.

    Raises:
      RunError: the disk is full, or the file cannot be written.
    """
    try:
        with path.open("ab") as file:
            file.write(line + b"\n")
    except OSError as error:
        raise RunError(f"{path} could not be written: {describe(error)}") from error


def read(path: Path) -> bytes:
    """Returns a file's content.

    Raises:
      RunError: it cannot be read.
    """
    try:
        return path.read_bytes()
    except OSError as error:
        raise RunError(f"{path} could not be read: {describe(error)}") from error


def read_json(path: Path, kind: type[T]) -> T | None:
    """Returns what a JSON file holds, None if there is none.

    Raises:
      RunError: it cannot be read, or holds something else than `kind`.
    """
    if not path.exists():
        return None
    try:
        return msgspec.json.decode(read(path), type=kind)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise RunError(f"{path} cannot be read: {error}") from None


def describe(error: OSError) -> str:
    """Returns why the system refused, in a few words."""
    return (error.strerror or str(error)).lower()
