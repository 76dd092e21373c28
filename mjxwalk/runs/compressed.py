"""Reads checkpoints of layout version 1: an array for each type of number, compressed."""

import hashlib
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import msgspec
import numpy as np
import numpy.typing as npt

from mjxwalk.runs import files, packing
from mjxwalk.runs.packing import Entry

MOST_BYTES = 1 << 28  # ours: of numbers; a hundred times any run that this layout was written by
FRAME_MAGIC = b"\x28\xb5\x2f\xfd"  # RFC 8878, section 3.1.1, as is all on frames here
SIZE_BYTES = {0: 1, 1: 2, 2: 4, 3: 8}


class _Zarr(msgspec.Struct):
    shape: tuple[int, ...]
    chunks: tuple[int, ...]
    dtype: str
    filters: None
    order: str


def restore(path: Path, entries: Sequence[Entry], expected: str) -> dict[str, npt.NDArray[Any]]:
    """Returns a checkpoint's arrays by name.

    Args:
      path: of its folder.
      entries: in the order in which those of one type lie end to end.
      expected: digest of them.

    Raises:
      ValueError: it does not fit its index or its digest, or is too large.
      Exception: whatever Orbax and what it stands on raise where files are damaged.
    """
    import orbax.checkpoint as ocp

    totals = _totals(entries)
    _check_sizes(path, totals)
    host = {name: ocp.RestoreArgs(restore_type=np.ndarray) for name in totals}
    with ocp.PyTreeCheckpointer(use_ocdbt=False) as orbax:
        wanted = dict.fromkeys(totals, 0)
        # Orbax takes a relative path for a damaged file.
        packed: Any = orbax.restore(path.resolve(), item=wanted, restore_args=host)
    if _digest(entries, packed) != expected:
        raise ValueError("its contents do not match their digest")
    used = dict.fromkeys(totals, 0)
    arrays: dict[str, npt.NDArray[Any]] = {}
    for name, dtype, shape in entries:
        start, used[dtype] = used[dtype], used[dtype] + math.prod(shape)
        arrays[name] = packed[dtype][start : used[dtype]].reshape(shape)
    return arrays


def _totals(entries: Sequence[Entry]) -> dict[str, int]:
    if packing.total(entries) > MOST_BYTES:
        raise ValueError(f"it asks for {packing.total(entries)} bytes")
    totals: dict[str, int] = {}
    for entry in entries:
        totals[entry.dtype] = totals.get(entry.dtype, 0) + math.prod(entry.shape)
    return totals


def _check_sizes(path: Path, totals: dict[str, int]) -> None:
    """Refuses arrays that do not fit the index, before anything is allocated for them."""
    for name, total in totals.items():
        header = msgspec.json.decode(_file(path, f"{name}/.zarray"), type=_Zarr)
        dtype = packing.dtype(name)
        one_chunk = header.shape == header.chunks == (total,) and header.order == "C"
        if not one_chunk or header.dtype != cast("str", dtype.str):
            raise ValueError(f"{name} holds {header.shape} numbers where the index has {total}")
        if _frame_size(_file(path, f"{name}/0")) != total * dtype.itemsize:
            raise ValueError(f"{name} would not come out of its compression as it went in")


def _file(path: Path, name: str) -> bytes:
    content = files.read_inside(path, name)
    if content is None:
        raise ValueError(f"it has no {name}")
    return content


def _frame_size(content: bytes) -> int | None:
    """Returns the bytes that a Zstandard frame says it holds, None if it does not say so."""
    if content[:4] != FRAME_MAGIC or len(content) < 5:
        return None
    descriptor = content[4]
    alone = bool(descriptor & 0x20)  # a single segment has no byte that tells a window's size
    kind = descriptor >> 6
    if kind == 0 and not alone:
        return None
    start = 5 + (not alone) + (0, 1, 2, 4)[descriptor & 3]
    told = int.from_bytes(content[start : start + SIZE_BYTES[kind]], "little")
    return told + 256 if kind == 1 else told


def _digest(entries: Sequence[Entry], packed: dict[str, npt.NDArray[Any]]) -> str:
    digest = hashlib.blake2b(msgspec.json.encode(entries), digest_size=16)
    for name in sorted(packed):
        digest.update(np.ascontiguousarray(packed[name]).data.cast("B"))
    return digest.hexdigest()
