"""A folder that one process at a time works on, and that leads nowhere else."""

import contextlib
import fcntl
import os
from collections.abc import Generator
from pathlib import Path

from mjxwalk.errors import RunError
from mjxwalk.runs import files

LOCK_FILE = ".lock"
CHECKPOINTS = "checkpoints"  # folder in a run's folder


def check_links(path: Path) -> None:
    """Returns if nothing in a run's folder is a link; the folder itself may be one.

    What is written to a link lands wherever whoever made the folder wanted it.

    Raises:
      RunError: there is a link.
    """
    found = [each for place in (path, path / CHECKPOINTS) for each in _inside(place)]
    for each in found:
        if each.is_symlink():
            raise RunError(
                f"{each} is a link, which can lead out of the folder; put what it leads to in its "
                "place"
            )


def _inside(path: Path) -> list[Path]:
    return sorted(path.iterdir()) if path.is_dir() else []


@contextlib.contextmanager
def locked(path: Path) -> Generator[None]:
    """Keeps other processes from working in a folder, until the block ends or this process does.

    Raises:
      RunError: another process has it, the folder cannot be written, or a link is in it.
    """
    check_links(path)
    try:
        # The file stays: removing it would let a third process lock a new one beside a second.
        descriptor = os.open(path / LOCK_FILE, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o644)
    except OSError as error:
        raise RunError(f"{path} cannot be written: {files.describe(error)}") from error
    try:
        if not is_free(descriptor, path):
            raise RunError(f"another process is working on {path}; wait for it to end")
        yield
    finally:
        os.close(descriptor)


def is_locked(path: Path) -> bool:
    """Returns whether a process is working in a folder."""
    try:
        descriptor = os.open(path / LOCK_FILE, os.O_RDWR)
    except OSError:
        return False
    try:
        return not is_free(descriptor, path)
    finally:
        os.close(descriptor)


def is_free(descriptor: int, path: Path) -> bool:
    """Returns whether no other process has an open file's lock, which is then ours.

    It is so until the last process that inherited the file has closed it.
    """
    del path
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
