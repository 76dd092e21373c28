"""JSON files that show whether they were changed: each holds a digest of what else it holds."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from mjxwalk.errors import RunError
from mjxwalk.runs import files

DIGEST = "digest"


def with_digest(data: object, **named: str) -> bytes:
    """Returns the content of a JSON file with a digest in it.

    Args:
      data: of the file, a table.
      named: what is put before it.
    """
    plain = msgspec.json.decode(msgspec.json.encode(data), type=dict[str, Any])
    plain = {**named, **{name: value for name, value in plain.items() if name not in named}}
    text = msgspec.json.encode({DIGEST: of_table(plain), **_without_digest(plain)})
    return msgspec.json.format(text, indent=2) + b"\n"


def check(path: Path, content: bytes, *, needed: bool) -> None:
    """Raises RunError unless a file's content, JSON with a table, is what was written.

    It may be laid out anew.

    Args:
      path: of the file, for the complaint.
      content: of the file.
      needed: whether there must be a digest; files of older versions have none.
    """
    plain = files.decode_table(path, content)
    found = plain.get(DIGEST)
    if found is None and not needed:
        return
    if found != of_table(plain):
        raise RunError(
            f"{path} was changed since it was written (its contents do not match its digest); put "
            "back the file as it was, or evolve anew with other settings"
        )


def of_table(data: Mapping[str, Any]) -> str:
    """Returns what tells a table from any other; a digest that it holds does not count."""
    return of_bytes(msgspec.json.encode(_without_digest(data)))


def of_bytes(content: bytes) -> str:
    """Returns what tells a file's content from any other."""
    return hashlib.blake2b(content, digest_size=16).hexdigest()


def _without_digest(data: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in data.items() if name != DIGEST}
