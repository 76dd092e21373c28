"""Files that the user names, which may be anything that can be written to.

A link is followed. A plain file is replaced whole, so that a reader finds the old content or the
new, and keeps its mode. What is no plain file (a pipe, a device), has a second name (a hard link)
or belongs to somebody else stays what it is, and is written to in place.
"""

import contextlib
import errno
import io
import os
import secrets
import stat
import sys
from pathlib import Path
from typing import Any

import msgspec

from mjxwalk import open_flags
from mjxwalk.errors import RunError
from mjxwalk.runs import files

# Why no file can be put in the place of another, although that one may be writable.
NO_REPLACING = (errno.EACCES, errno.EPERM, errno.EROFS, errno.EBUSY, errno.EXDEV)


def check(path: Path, flag: str = "--out") -> None:
    """Raises RunError unless a file could be written; nothing is changed or made.

    Args:
      path: of the file.
      flag: that names it.
    """
    try:
        found = _stat(path)
        folder = Path(os.path.realpath(path)).parent
        if found is not None and stat.S_ISDIR(found.st_mode):
            raise RunError(f"{flag} {path} is a folder; name a file in it")
        if found is None and not folder.is_dir():
            raise RunError(f"{flag} {path} is in no folder that is there; make {path.parent} first")
        if not os.access(folder if found is None else path, os.W_OK):
            raise RunError(f"{flag} {path} cannot be written: permission denied")
    except OSError as error:
        raise RunError(f"{flag} {path} cannot be written: {files.describe(error)}") from None


def write(path: Path, content: bytes, *, run: Path | None = None) -> None:
    """Writes a file.

    Args:
      path: of the file.
      content: of the file.
      run: folder of the run that has the file by default; None for one that the user named.

    Raises:
      RunError: the disk is full, or the file cannot be written.
    """
    if run is not None:
        files.replace(run, path.relative_to(run).as_posix(), content)
        return
    try:
        found = _stat(path)
        target = Path(os.path.realpath(path))
        if not (_is_replaceable(target, found) and _replace(target, content, found)):
            _write_in_place(path, content)
    except OSError as error:
        raise RunError(f"{path} could not be written: {files.describe(error)}") from None


def create(path: Path, content: bytes) -> None:
    """Writes a file that was not there.

    Raises:
      RunError: something is there already, or the file cannot be written.
    """
    try:
        with path.open("xb") as file:
            file.write(content)
    except FileExistsError:
        raise RunError(f"{path} is there already; choose another name") from None
    except OSError as error:
        raise RunError(f"{path} could not be written: {files.describe(error)}") from None


def as_json(data: Any) -> bytes:
    """Returns the content of a JSON file."""
    return msgspec.json.format(msgspec.json.encode(data), indent=2) + b"\n"


def write_text(path: Path, text: str) -> None:
    """Writes a file with text, such as a table; what is no UTF-8 in it is written as escapes.

    Raises:
      RunError: the disk is full, or the file cannot be written.
    """
    write(path, text.encode(errors="backslashreplace"))


def write_figure(path: Path, figure: Any, **options: Any) -> None:
    """Writes a figure of matplotlib; the path's ending says which kind, png without one.

    Args:
      path: of the file.
      figure: to draw.
      options: of matplotlib's `savefig`.

    Raises:
      RunError: the ending is of no kind of picture, or the file cannot be written.
    """
    buffer = io.BytesIO()
    try:
        figure.savefig(buffer, format=path.suffix[1:].lower() or "png", **options)
    except ValueError as error:
        raise RunError(f"{path} could not be written: {error}") from None
    write(path, buffer.getvalue())


def is_stream(path: Path) -> bool:
    """Returns whether something other than a plain file is at a path."""
    found = _stat(path)
    return found is not None and not stat.S_ISREG(found.st_mode)


def tell(path: Path) -> None:
    """Prints the path of a file that was written, unless it was written to where prints go."""
    found = _stat(path)
    if found is None or _standard(found) is None:
        print(path, flush=True)


def _stat(path: Path) -> os.stat_result | None:
    with contextlib.suppress(FileNotFoundError):
        return os.stat(path)
    return None


def _is_replaceable(target: Path, found: os.stat_result | None) -> bool:
    if found is None:
        return True
    is_plain = stat.S_ISREG(found.st_mode) and found.st_nlink == 1
    # What is reached by way of /dev/fd may have no name any more, and stdout goes on afterwards.
    is_named = (there := _stat(target)) is not None and os.path.samestat(found, there)
    return is_plain and is_named and _standard(found) is None


def _replace(target: Path, content: bytes, found: os.stat_result | None) -> bool:
    """Returns whether a new file could be put in the place of the old one."""
    unfinished = target.with_name(f".mjxwalk-{secrets.token_hex(8)}.partial")
    try:
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | open_flags.NO_LINK
        with open(os.open(unfinished, flags, 0o666), "wb") as file:
            if found is not None:
                made = os.fstat(file.fileno())
                if (made.st_uid, made.st_gid) != (found.st_uid, found.st_gid):
                    return False
                if hasattr(os, "fchmod"):  # Windows before Python 3.13 has a folder's rights
                    os.fchmod(file.fileno(), stat.S_IMODE(found.st_mode))
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(unfinished, target)
        return True
    except OSError as error:
        if found is None or error.errno not in NO_REPLACING:
            raise
        return False
    finally:
        with contextlib.suppress(OSError):  # after it got its name it is not there
            os.unlink(unfinished)


def _write_in_place(path: Path, content: bytes) -> None:
    standard = _standard(os.stat(path))
    if standard is not None:
        sys.stdout.flush()
        descriptor = os.dup(standard)  # opened anew, it would be written to from its beginning
    else:
        descriptor = os.open(path, os.O_WRONLY | os.O_TRUNC | open_flags.NO_TERMINAL)
    with open(descriptor, "wb") as file:
        file.write(content)


def _standard(found: os.stat_result) -> int | None:
    """Returns which of standard output and standard error a file is, None for neither."""
    for descriptor in (1, 2):
        with contextlib.suppress(OSError):  # it is closed
            if sys.stdout is not None and os.path.samestat(found, os.fstat(descriptor)):
                return descriptor
    return None
