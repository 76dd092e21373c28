"""Folders of this user's own, for machine code that is kept between processes.

Whoever can write there decides what this user's processes run. A folder is therefore used only if
it belongs to the user and nobody else can write to it; otherwise everything works without it.
"""

import functools
import logging
import os
import stat
from pathlib import Path

OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def folder(name: str) -> Path | None:
    """Returns a folder under XDG_CACHE_HOME or ~/.cache, made if missing, or None without one.

    Why there is none is logged once, as a warning.
    """
    try:
        base = _base()
        place = claimed(base) / name
        _claim(place)
        return place
    except _Refused as reason:
        _warn(str(reason))
    except OSError as error:
        _warn(f"its folder cannot be made: {error.strerror or error}")
    return None


def claimed(base: Path) -> Path:
    """Returns the folder `mjxwalk` in another, made if missing, which only this user can enter.

    Raises:
      OSError: it cannot be made, or others could write to it or put another in its place.
    """
    _make(base)
    _check_parents(base)
    place = base / "mjxwalk"
    _claim(place)
    return place


def is_private(status: os.stat_result) -> bool:
    """Returns whether a file belongs to this user, and nobody else can write to it."""
    if not hasattr(os, "geteuid"):  # Windows: a user's folders are protected by where they are
        return True
    return status.st_uid == os.geteuid() and not status.st_mode & OTHERS_WRITE


class _Refused(OSError):
    """Raised with the reason why a folder is not used."""


def _base() -> Path:
    told = os.environ.get("XDG_CACHE_HOME", "")
    if os.path.isabs(told):  # the XDG specification: relative paths are ignored
        return Path(told)
    home = os.path.expanduser("~")
    if os.path.isabs(home):
        return Path(home) / ".cache"
    raise _Refused("this user has no home folder; set XDG_CACHE_HOME to a folder")


def _claim(place: Path) -> None:
    """Makes a folder that only this user can enter; raises _Refused unless it is theirs alone."""
    _make(place)
    status = place.stat()
    if not is_private(status):
        raise _Refused(
            f"{place} belongs to another user or can be written by others; remove it, or set "
            "XDG_CACHE_HOME to a folder of your own"
        )
    if status.st_mode & 0o077 and hasattr(os, "geteuid"):
        place.chmod(0o700)


def _make(place: Path) -> None:
    if place.is_dir():
        return
    _make(place.parent)
    place.mkdir(exist_ok=True)
    place.chmod(0o700)  # whatever the umask


def _check_parents(base: Path) -> None:
    """Raises _Refused if anybody can put another folder in the place of one above."""
    real = base.resolve()
    for parent in (real, *real.parents):
        mode = parent.stat().st_mode
        if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
            raise _Refused(
                f"everybody can write to {parent}; set XDG_CACHE_HOME to a folder of your own"
            )


@functools.cache  # one process says it once
def _warn(reason: str) -> None:
    logging.getLogger("mjxwalk").warning("mjxwalk keeps no compiled code on disk: %s", reason)
