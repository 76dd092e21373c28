"""A folder that one process at a time works on, and that leads nowhere else."""

import contextlib
import errno
import functools
import os
import sys
from collections.abc import Generator
from pathlib import Path

from mjxwalk import file_lock
from mjxwalk.errors import RunError
from mjxwalk.runs import config, files, way

LOCK_FILE = ".lock"
CHECKPOINTS = "checkpoints"  # folder in a run's folder
AROUND = ("study.json", "sweep.json")  # in a folder with runs in it; what writes them needs locks
# Of network and parallel file systems that were mounted without locks.
WITHOUT_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP)


def check_links(path: Path) -> None:
    """Raises RunError if anything in the folder of a run, a study or a sweep is a link.

    What is written to a link lands wherever whoever made the folder wanted it. The folder itself
    may be a link, unless it is in a study or a sweep. Runs in the folder are looked at when their
    turn comes.
    """
    if any((path.parent / name).exists() for name in AROUND):
        way.check_no_link(path, way.lstat(path, None))
    for place, folders, names in os.walk(path):
        for name in sorted((*folders, *names)):
            inside = Path(place, name)
            way.check_no_link(inside, way.lstat(inside, None))
        folders[:] = [
            name for name in folders if not os.path.exists(Path(place, name, config.FILE))
        ]


@contextlib.contextmanager
def locked(path: Path) -> Generator[None]:
    """Keeps other processes from working in a folder, until the block ends or this process does.

    Raises:
      RunError: another process has it, the folder cannot be written, or a link is in it.
    """
    check_links(path)
    try:
        # The file stays: removing it would let a third process lock a new one beside a second.
        descriptor = way.opened(path / LOCK_FILE, os.O_RDWR | os.O_CREAT, None, path / LOCK_FILE)
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
        descriptor = way.opened(path / LOCK_FILE, os.O_RDWR, None, path / LOCK_FILE)
    except (OSError, RunError):
        return False
    try:
        return not is_free(descriptor, path)
    except RunError:
        return False
    finally:
        os.close(descriptor)


def is_free(descriptor: int, path: Path) -> bool:
    """Returns whether no other process has the lock; locks it, if the file system has locks.

    Raises:
      RunError: the file system fails.
    """
    try:
        return file_lock.lock(descriptor, waits=False)
    except OSError as error:
        if error.errno not in WITHOUT_LOCKS:
            raise RunError(f"{path} could not be locked: {files.describe(error)}") from error
        _note_no_locks(path)
    return True


@functools.cache  # a run is locked several times
def _note_no_locks(path: Path) -> None:
    print(
        f"mjxwalk: the file system of {path} has no locks; let no second process work on it",
        file=sys.stderr,
        flush=True,
    )
