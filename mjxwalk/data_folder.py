"""Small files of this user's own that are kept: in XDG_DATA_HOME, or LOCALAPPDATA on Windows.

Nobody else can write them, or they count for nothing.
"""

import contextlib
import os
import stat
from pathlib import Path

from mjxwalk import cache_folder, open_flags

MOST_BYTES = 1 << 24  # ours: of a file of lines; a hundred thousand of them


def folder() -> Path:
    """Returns the folder, made if it is missing.

    Raises:
      OSError: it cannot be made, or another user could write to it.
    """
    return cache_folder.claimed(_base())


def lines(name: str) -> set[str]:
    """Returns the first word of each line of a file, none where it is missing or not private."""
    try:
        flags = os.O_RDONLY | open_flags.NO_LINK | open_flags.NO_WAITING
        descriptor = os.open(folder() / name, flags)
    except OSError:
        return set()
    with open(descriptor, "rb") as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode) or not cache_folder.is_private(status):
            return set()
        text = file.read(MOST_BYTES).decode(errors="replace")
    return {line.split()[0] for line in text.splitlines() if line.split()}


def append(name: str, line: str) -> None:
    """Adds a line to a file that only this user can read, mode 0600, if that can be."""
    with contextlib.suppress(OSError):
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | open_flags.NO_LINK
        with open(os.open(folder() / name, flags, 0o600), "ab", buffering=0) as file:
            status = os.fstat(file.fileno())
            # One that others could write to may hold what they wrote: it counts for nothing.
            if stat.S_ISREG(status.st_mode) and cache_folder.is_private(status):
                file.write(f"{line}\n".encode())


def _base() -> Path:
    for variable in ("XDG_DATA_HOME", *(("LOCALAPPDATA",) if os.name == "nt" else ())):
        told = os.environ.get(variable, "")
        if os.path.isabs(told):
            return Path(told)
    home = os.path.expanduser("~")
    if os.path.isabs(home):
        return Path(home) / ".local" / "share"
    raise OSError("this user has no home folder; set XDG_DATA_HOME to a folder")
