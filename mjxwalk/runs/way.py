"""The way to a file in a folder that may come from anybody: it follows no link.

Windows opens no folder, and no file relative to one. There a path is looked at before it is used,
so that whoever can write in the folder at that very time can still put a link in between.
"""

import contextlib
import os
import stat
from collections.abc import Generator
from pathlib import Path

from mjxwalk import open_flags
from mjxwalk.errors import RunError

OPENS_FOLDERS = os.open in os.supports_dir_fd
JUNCTION = 0xA0000003  # stat.IO_REPARSE_TAG_MOUNT_POINT, a link to a folder on Windows


@contextlib.contextmanager
def follow(folder: Path, name: str, *, is_made: bool = False) -> Generator[tuple[int | None, str]]:
    """Yields an open folder and the last part of a name in it; no link is followed on the way.

    On Windows it yields None and the path of the last part.

    Args:
      folder: where the way begins.
      name: from there.
      is_made: whether folders that are missing are made.

    Raises:
      OSError: a folder is missing, or cannot be opened.
      RunError: a link or no folder is on the way, or the name leads out of the folder.
    """
    parts = name.replace(os.sep, "/").split("/")
    if os.path.isabs(name) or os.path.splitdrive(name)[0] or ".." in parts:
        raise RunError(f"{name} leads out of {folder}")
    *between, last = parts
    if not OPENS_FOLDERS:
        yield None, str(_looked_at(folder, between, is_made=is_made) / last)
        return
    place, path = os.open(folder, os.O_RDONLY | open_flags.ONLY_FOLDER), folder
    try:
        for part in between:
            path /= part
            if is_made:
                with contextlib.suppress(FileExistsError):
                    os.mkdir(part, dir_fd=place)
            outer, place = place, opened(part, os.O_RDONLY, place, path, is_folder=True)
            os.close(outer)
        yield place, last
    finally:
        os.close(place)


def opened(
    name: str | Path,
    flags: int,
    place: int | None,
    path: Path,
    *,
    is_folder: bool = False,
    may_be_link: bool = False,
) -> int:
    """Returns the descriptor of a plain file or of a folder; a pipe is not waited for.

    Args:
      name: of the file.
      flags: as `os.open` takes them.
      place: descriptor of the folder that the name is in; None for where the process works.
      path: of the file, for the complaint.
      is_folder: whether it must be a folder.
      may_be_link: whether a link is followed.

    Raises:
      OSError: it cannot be opened.
      RunError: it is a link or no plain file.
    """
    flags |= open_flags.NO_WAITING
    flags |= open_flags.ONLY_FOLDER if is_folder else 0
    if not may_be_link:
        flags |= open_flags.NO_LINK
        if not open_flags.NO_LINK:
            check_no_link(path, lstat(name, place))
    try:
        descriptor = os.open(name, flags, 0o666, dir_fd=place)
    except OSError:
        if not may_be_link:
            check_no_link(path, lstat(name, place))
        raise
    is_right = stat.S_ISDIR if is_folder else stat.S_ISREG
    if not is_right(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise RunError(f"{path} could not be used: it is no plain file")
    return descriptor


def check_no_link(path: Path, found: os.stat_result | None) -> None:
    """Raises RunError if what was found at a path is a link."""
    if found is None:
        return
    if stat.S_ISLNK(found.st_mode) or getattr(found, "st_reparse_tag", 0) == JUNCTION:
        raise RunError(
            f"{path} is a link, which can lead out of the folder; put what it leads to in its place"
        )


def lstat(name: str | Path, place: int | None) -> os.stat_result | None:
    """Returns what is known of a file or a link itself, None if it is not there."""
    with contextlib.suppress(OSError):
        return os.stat(name, dir_fd=place, follow_symlinks=False)
    return None


def sync_folder(place: int | None) -> None:
    """Returns when the names in an open folder are on the disk; Windows keeps them by itself."""
    if place is not None:
        os.fsync(place)


def _looked_at(folder: Path, between: list[str], *, is_made: bool) -> Path:
    """Returns the folder at the end of a way on which no link was found."""
    path = folder
    os.scandir(path).close()
    for part in between:
        path /= part
        if is_made:
            with contextlib.suppress(FileExistsError):
                os.mkdir(path)
        check_no_link(path, lstat(path, None))
        os.scandir(path).close()  # as opening it would, raises unless it is a folder
    return path
