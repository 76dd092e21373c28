"""Named arrays end to end as bytes, and the index that says which piece is which."""

import hashlib
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

Arrays = Mapping[str, npt.NDArray[Any]]

DTYPES = frozenset(
    ["bool", "float16", "bfloat16", "float32", "float64"]
    + [f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)]
)


class Entry(NamedTuple):
    """One named array, by its place in the index: it lies after those before it."""

    name: str
    dtype: str
    shape: tuple[int, ...]


class Index(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a checkpoint says of itself."""

    schema: int
    generation: int
    entries: tuple[Entry, ...]
    digest: str
    run: str | None = None


def pack(arrays: Arrays) -> tuple[npt.NDArray[np.uint8], tuple[Entry, ...]]:
    """Returns the bytes of all arrays, and what they are."""
    entries = tuple(Entry(name, a.dtype.name, a.shape) for name, a in arrays.items())
    pieces = [np.ascontiguousarray(array).reshape(-1).view(np.uint8) for array in arrays.values()]
    return np.concatenate(pieces) if pieces else np.zeros(0, np.uint8), entries


def unpack(content: bytes, entries: Sequence[Entry]) -> dict[str, npt.NDArray[Any]]:
    """Returns the arrays by name.

    Raises:
      ValueError: the index does not fit the bytes, or names a type that is none.
    """
    if total(entries) != len(content):
        raise ValueError(f"it holds {len(content)} bytes where the index has {total(entries)}")
    arrays: dict[str, npt.NDArray[Any]] = {}
    start = 0
    for entry in entries:
        stop = start + size(entry)
        # A copy, since a piece of the bytes may lie where no number of its type may.
        piece = np.frombuffer(content[start:stop], dtype(entry.dtype)).copy()
        arrays[entry.name] = piece.reshape(entry.shape)
        start = stop
    if len(arrays) < len(entries):
        raise ValueError("the index has two arrays of one name")
    return arrays


def digest(
    generation: int, entries: Sequence[Entry], content: bytes | memoryview, run: str | None
) -> str:
    """Returns what tells these arrays of this generation, of this run, from any others."""
    told = (generation, entries) if run is None else (generation, entries, run)
    blake = hashlib.blake2b(msgspec.json.encode(told), digest_size=16)
    blake.update(content)
    return blake.hexdigest()


def total(entries: Sequence[Entry]) -> int:
    """Returns the bytes that all arrays take."""
    return sum(map(size, entries))


def size(entry: Entry) -> int:
    """Returns the bytes that an array takes.

    Raises:
      ValueError: it has no such type or shape.
    """
    if any(length < 0 for length in entry.shape):
        raise ValueError(f"{entry.name} has the shape {list(entry.shape)}")
    return math.prod(entry.shape) * dtype(entry.dtype).itemsize


def dtype(name: str) -> np.dtype[Any]:
    """Returns the type of that name.

    Raises:
      ValueError: there is none, or it is not of plain numbers.
    """
    if name not in DTYPES:
        raise ValueError(f"it holds {name!r}, which are not plain numbers")
    if name == "bfloat16":
        import ml_dtypes  # comes with JAX

        return np.dtype(ml_dtypes.bfloat16)
    return np.dtype(name)
