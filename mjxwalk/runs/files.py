"""Files of a run: replaced whole, appended by the line, read within limits, errors in words.

What is read may come from anybody, what is written may meet a power loss.
"""

import contextlib
import os
import stat
from pathlib import Path
from typing import TypeVar

import msgspec

from mjxwalk.errors import RunError

T = TypeVar("T")

# What msgspec raises where bytes are not the JSON that they should be; the last of too many layers.
MALFORMED = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)

MOST_BYTES = 1 << 28  # ours: of a file with text; the figures of 300,000 generations take as much


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
        sync(path.parent)
    except OSError as error:
        with contextlib.suppress(OSError):  # a folder that cannot be written
            unfinished.unlink(missing_ok=True)
        raise RunError(f"{path} could not be written: {describe(error)}") from error


def sync(path: Path) -> None:
    """Returns when what was written to a file, or which names a folder has, is on the disk itself.

    Raises:
      OSError: the system cannot tell.
    """
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


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


def read(path: Path, most: int = MOST_BYTES) -> bytes:
    """Returns a file's content, of so many bytes at most.

    Raises:
      RunError: it cannot be read, is too large, or is no plain file, such as a pipe.
    """
    try:
        # A pipe that nobody writes to would block.
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        with open(descriptor, "rb") as file:
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                raise RunError(f"{path} could not be read: it is no plain file")
            content = file.read(most + 1)
    except OSError as error:
        raise RunError(f"{path} could not be read: {describe(error)}") from error
    if len(content) > most:
        raise RunError(f"{path} could not be read: it has more than {most} bytes")
    return content


def read_json(path: Path, kind: type[T]) -> T | None:
    """Returns what a JSON file holds, None if there is none.

    Raises:
      RunError: it cannot be read, or holds something else than `kind`.
    """
    if not path.exists():
        return None
    try:
        return msgspec.json.decode(read(path), type=kind)
    except MALFORMED as error:
        raise RunError(f"{path} cannot be read: {error}") from None


def describe(error: OSError) -> str:
    """Returns why the system refused, in a few words."""
    return (error.strerror or str(error)).lower()
