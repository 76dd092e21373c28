"""Kernels on disk: entries that are whole or not there.

An entry is a file: the SHA-256 of its name and the rest, a line of JSON, object code. It is written
under another name and renamed, so that two processes can write one entry; what does not match its
checksum, or is not a file of this user's alone, is as good as absent. A disk that cannot be written
costs time, never a result.
"""

import contextlib
import hashlib
import json
import os
import stat
import tempfile
from collections.abc import Generator
from pathlib import Path
from typing import Any, cast

from mjxwalk import cache_folder, file_lock, open_flags

Header = dict[str, Any]  # JSON

MOST_BYTES = 1 << 28  # of an entry; ours: the largest of our kernels has some megabytes


def digest(*parts: str) -> str:
    """Returns the name of an entry that depends on all of these."""
    text = "".join(f"{len(part)}:{part}" for part in parts)
    return hashlib.sha256(text.encode(errors="surrogateescape")).hexdigest()


def read(name: str) -> tuple[Header, bytes] | None:
    """Returns an entry, or None if it is absent, damaged, or not this user's alone."""
    folder = cache_folder.folder("lanes")
    if folder is None:
        return None
    try:
        whole = _content(folder / name)
        checksum, rest = whole[:64], whole[64:]
        if _checksum(name, rest) != checksum:
            return None
        line, _, code = rest.partition(b"\n")
        return cast(Header, json.loads(line)), code
    except (OSError, ValueError, RecursionError):
        return None


def _content(path: Path) -> bytes:
    descriptor = os.open(path, os.O_RDONLY | open_flags.NO_LINK | open_flags.NO_WAITING)
    with os.fdopen(descriptor, "rb") as file:
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode) or not cache_folder.is_private(status):
            return b""
        return file.read(min(MOST_BYTES, status.st_size))


def _checksum(name: str, rest: bytes) -> bytes:
    return hashlib.sha256(name.encode() + b"\n" + rest).hexdigest().encode()


@contextlib.contextmanager
def alone(kind: str, name: str) -> Generator[None]:
    """Keeps other processes, and threads, from making the same entry until the block ends.

    Without a disk to tell them by, all make it. A block may contain another of a second kind, as
    long as all nest the two in the same order.
    """
    descriptor = -1
    folder = cache_folder.folder("lanes")
    try:
        if folder is not None:
            # One of a few files, which stay: one for each entry would litter the folder.
            path = folder / f".making-{kind}-{name[:2]}"
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | open_flags.NO_LINK, 0o600)
            file_lock.lock(descriptor, waits=True)
    except OSError:
        pass
    try:
        yield
    finally:
        if descriptor >= 0:
            os.close(descriptor)


def write(name: str, header: Header, code: bytes) -> None:
    """Writes an entry, whole or not at all."""
    folder = cache_folder.folder("lanes")
    if folder is None:
        return
    rest = json.dumps(header).encode() + b"\n" + code
    try:
        descriptor, path = tempfile.mkstemp(dir=folder, prefix=".writing-")
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(_checksum(name, rest) + rest)
            os.replace(path, folder / name)
        except OSError:
            os.unlink(path)
    except OSError:
        return
