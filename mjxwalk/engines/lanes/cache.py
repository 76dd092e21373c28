"""Kernels on disk: entries that are whole or not there.

An entry is a file: the SHA-256 of the rest, a line of JSON, object code. It is written under
another name and renamed, so that two processes can write one entry; what does not match its
checksum is as good as absent. A disk that cannot be written costs time, never a result.
"""

import hashlib
import json
import os
import tempfile
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
