"""The way to a file in a folder that may come from anybody: it follows no link."""

import contextlib
import os
import stat
from collections.abc import Generator
from pathlib import Path

from mjxwalk.errors import RunError


@contextlib.contextmanager
def follow(folder: Path, name: str, *, is_made: bool = False) -> Generator[tuple[int, str]]:
    """Yields an open folder and the last part of a name in it; no link is followed on the way.

    Args:
      folder: where the way begins.
      name: from there.
      is_made: whether folders that are missing are made.

    Raises:
      OSError: a folder is missing, or cannot be opened.
      RunError: a link or no folder is on the way, or the name leads out of the folder.
    """
    if os.path.isabs(name) or ".." in name.split("/"):
        raise RunError(f"{name} leads out of {folder}")
    *between, last = name.split("/")
    place, path = os.open(folder, os.O_RDONLY | os.O_DIRECTORY), folder
    try:
        for part in between:
            path /= part
            if is_made:
                with contextlib.suppress(FileExistsError):
                    os.mkdir(part, dir_fd=place)
            flags = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW
            outer, place = place, opened(part, flags, place, path)
            os.close(outer)
        yield place, last
    finally:
        os.close(place)


def opened(name: str | Path, flags: int, place: int | None, path: Path) -> int:
    """Returns the descriptor of a plain file or, if the flags ask for one, of a folder.

    Args:
      name: of the file.
      flags: as `os.open` takes them; with O_NOFOLLOW a link is refused.
      place: descriptor of the folder that the name is in; None for where the process works.
      path: of the file, for the complaint.

    Raises:
      OSError: it cannot be opened.
      RunError: it is a link or no plain file.
    """
    try:
        descriptor = os.open(name, flags, 0o666, dir_fd=place)
    except OSError:
        if flags & os.O_NOFOLLOW:
            check_no_link(path, lstat(name, place))
        raise
    is_right = stat.S_ISDIR if flags & os.O_DIRECTORY else stat.S_ISREG
    if not is_right(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise RunError(f"{path} could not be used: it is no plain file")
    return descriptor


def check_no_link(path: Path, found: os.stat_result | None) -> None:
    """Raises RunError if what was found at a path is a link."""
    if found is not None and stat.S_ISLNK(found.st_mode):
        raise RunError(
            f"{path} is a link, which can lead out of the folder; put what it leads to in its place"
        )


def lstat(name: str | Path, place: int | None) -> os.stat_result | None:
    """Returns what is known of a file or a link itself, None if it is not there."""
    with contextlib.suppress(OSError):
        return os.stat(name, dir_fd=place, follow_symlinks=False)
    return None
