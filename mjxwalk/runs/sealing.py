"""JSON files that show whether they were changed: each holds a digest of what else it holds."""

import hashlib
from pathlib import Path
from typing import Any

import msgspec

from mjxwalk.errors import RunError

DIGEST = "digest"


def sealed(data: object) -> bytes:
    """Returns the content of a JSON file with a digest in it."""
    plain = msgspec.json.decode(msgspec.json.encode(data), type=dict[str, Any])
    plain.pop(DIGEST, None)
    text = msgspec.json.encode({DIGEST: _digest(plain), **plain})
    return msgspec.json.format(text, indent=2) + b"\n"


def check(path: Path, content: bytes, *, needed: bool) -> None:
    """Returns if a file's content, JSON with a table, is what was written, however it is laid out.

    Args:
      path: of the file, for the complaint.
      content: of the file.
      needed: whether there must be a digest; files of older versions have none.

    Raises:
      RunError: it was changed.
    """
    plain = msgspec.json.decode(content, type=dict[str, Any])
    found = plain.pop(DIGEST, None)
    if found is None and not needed:
        return
    if found != _digest(plain):
        raise RunError(
            f"{path} was changed since it was written (its contents do not match its digest); put "
            "back the file as it was, or evolve anew with other settings"
        )


def _digest(plain: dict[str, Any]) -> str:
    return hashlib.blake2b(msgspec.json.encode(plain), digest_size=16).hexdigest()
