"""Series of numbers made small: whole steps, their differences, high and low bytes apart, gzip."""

import base64
import gzip
from collections.abc import Mapping
from typing import Any, NamedTuple

import msgspec
import numpy as np

LARGEST = 32_000  # steps between neighbours; what does not fit gets coarser steps


class Series(NamedTuple):
    """Numbers to pack.

    Attributes:
      values: [channel, place]; neighbours along the last axis are alike.
      step: that values are rounded to.
    """

    values: Any
    step: float


class Stored(msgspec.Struct, frozen=True, kw_only=True):
    """Where packed numbers lie.

    Attributes:
      channels: number of them.
      places: of each channel.
      step: that values were rounded to.
      offset: of the first byte, once unzipped.
    """

    channels: int
    places: int
    step: float
    offset: int


def pack(series: Mapping[str, Series]) -> tuple[dict[str, Stored], str]:
    """Returns where each series lies, and all of them as base64 text; the same for the same."""
    stored: dict[str, Stored] = {}
    pieces: list[bytes] = []
    offset = 0
    for name, (values, step) in series.items():
        values = np.asarray(values, np.float64)
        changes = np.abs(np.diff(values, axis=1, prepend=0.0))
        step = max(step, float(changes.max(initial=0.0)) / LARGEST)
        steps = np.rint(values / step).astype(np.int64)
        changes = np.diff(steps, axis=1, prepend=0).astype("<i2")
        planes = changes.reshape(*changes.shape, 1).view(np.uint8)
        piece = planes[..., 1].tobytes() + planes[..., 0].tobytes()
        channels, places = values.shape
        stored[name] = Stored(channels=channels, places=places, step=step, offset=offset)
        pieces.append(piece)
        offset += len(piece)
    packed = gzip.compress(b"".join(pieces), compresslevel=9, mtime=0)
    return stored, base64.b64encode(packed).decode()


def unpack(stored: Mapping[str, Stored], text: str) -> dict[str, Any]:
    """Returns the numbers as the page reads them."""
    content = np.frombuffer(gzip.decompress(base64.b64decode(text)), np.uint8)
    found: dict[str, Any] = {}
    for name, where in stored.items():
        size = where.channels * where.places
        high, low = (
            content[where.offset + part * size :][:size].reshape(where.channels, where.places)
            for part in (0, 1)
        )
        changes = (high.view(np.int8).astype(np.int32) << 8) | low
        found[name] = np.cumsum(changes, axis=1) * where.step
    return found
