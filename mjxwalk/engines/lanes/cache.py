"""Kernels on disk: entries that are whole or not there.

An entry is a file: the SHA-256 of the rest, a line of JSON, object code. It is written under
another name and renamed, so that two processes can write one entry; what does not match its
checksum is as good as absent. A disk that cannot be written costs time, never a result.
"""

import contextlib
import fcntl
import hashlib
import json
import os
import tempfile
from collections.abc import Generator
from pathlib import Path
from typing import Any, cast

Header = dict[str, Any]  # JSON


def folder() -> Path:
    """Returns where entries are kept: under XDG_CACHE_HOME, or ~/.cache."""
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "mjxwalk" / "lanes"


def digest(*parts: str) -> str:
    """Returns the name of an entry that depends on all of these."""
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def read(name: str) -> tuple[Header, bytes] | None:
    """Returns an entry, or None if it is absent or damaged."""
    try:
        whole = (folder() / name).read_bytes()
        checksum, rest = whole[:64], whole[64:]
        if hashlib.sha256(rest).hexdigest().encode() != checksum:
            return None
        line, _, code = rest.partition(b"\n")
        return cast(Header, json.loads(line)), code
    except (OSError, ValueError):
        return None


@contextlib.contextmanager
def alone(name: str) -> Generator[None]:
    """Keeps other processes, and threads, from making the same entry until the block ends.

    Without a disk to tell them by, all make it.
    """
    descriptor = -1
    try:
        if name:
            folder().mkdir(parents=True, exist_ok=True)
            # One of a few files, which stay: one for each entry would litter the folder.
            descriptor = os.open(folder() / f".making-{name[:2]}", os.O_RDWR | os.O_CREAT, 0o644)
            fcntl.flock(descriptor, fcntl.LOCK_EX)
    except OSError:
        pass
    try:
        yield
    finally:
        if descriptor >= 0:
            os.close(descriptor)


def write(name: str, header: Header, code: bytes) -> None:
    """Writes an entry, whole or not at all."""
    rest = json.dumps(header).encode() + b"\n" + code
    try:
        folder().mkdir(parents=True, exist_ok=True)
        descriptor, path = tempfile.mkstemp(dir=folder(), prefix=".writing-")
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(hashlib.sha256(rest).hexdigest().encode() + rest)
            os.replace(path, folder() / name)
        except OSError:
            os.unlink(path)
    except OSError:
        return
