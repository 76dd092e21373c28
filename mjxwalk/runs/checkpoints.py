"""Generations on disk: one Orbax checkpoint each, written in the background, checked when read.

A checkpoint is a flat table of named arrays. Orbax needs a millisecond or two of Python for each
array that it writes and a genotype has dozens, so the arrays of one dtype are stored end to end as
one, and an index in the checkpoint's metadata says which piece is which. The metadata also holds a
digest of the bytes: Orbax by itself restores a flipped bit without a word.
"""

import hashlib
import logging
import math
import shutil
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple, cast

import msgspec
import numpy as np
import numpy.typing as npt
import orbax.checkpoint as ocp

from mjxwalk.errors import RunError

Arrays = Mapping[str, npt.NDArray[Any]]

SCHEMA = (
    1  # of the checkpoint's layout; raise it whenever an older reader would misread a newer one
)


def _is_news(record: logging.LogRecord) -> bool:
    # Orbax 0.12 warns at each save without OCDBT that there is nothing of OCDBT to merge.
    return "Skipping merge of OCDBT" not in record.getMessage()


logging.getLogger("absl").addFilter(_is_news)


class Entry(NamedTuple):
    """Where one named array lies: after those of its dtype that come before it in the index."""

    name: str
    dtype: str
    shape: tuple[int, ...]


class Index(msgspec.Struct, frozen=True, kw_only=True):
    """What a checkpoint says of itself."""

    schema: int
    generation: int
    entries: tuple[Entry, ...]
    digest: str


class Checkpoints:
    """The checkpoints of one run, in a folder with one folder for each generation.

    Saves overlap with the next generation's work, one at a time: a second save waits for the first.
    Use it as a context manager, or call `wait` before relying on what is on disk.
    """

    def __init__(self, folder: Path, *, keep: int | None = None) -> None:
        """Args: folder: made at the first save. keep: newest generations that stay; None is all."""
        self._folder = folder
        self._keep = keep
        self._orbax = ocp.PyTreeCheckpointer(use_ocdbt=False)
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="checkpoint")
        self._pending: Future[None] | None = None

    def __enter__(self) -> "Checkpoints":
        return self

    def __exit__(self, *_: object) -> None:
        self._worker.shutdown(wait=True)
        self._orbax.close()

    def generations(self) -> list[int]:
        """Returns the generations that have a finished checkpoint, oldest first."""
        return generations(self._folder)

    def save(self, generation: int, arrays: Arrays) -> None:
        """Starts writing a generation, after the save before it has ended.

        Raises:
          RunError: the save before it failed.
        """
        self.wait()
        self._pending = self._worker.submit(self._write, generation, dict(arrays))

    def wait(self) -> None:
        """Returns when everything saved is on disk.

        Raises:
          RunError: the last save failed, for example because the disk is full.
        """
        if self._pending is not None:
            try:
                self._pending.result()
            except RunError:
                self._pending = None
                raise
            # Not in a finally clause: a wait that Ctrl-C cuts short can be taken up again.
            self._pending = None

    def discard_after(self, generation: int) -> None:
        """Removes the checkpoints of later generations, and what a killed process left behind."""
        for path in _listdir(self._folder):
            if not path.name.isdigit() or int(path.name) > generation:
                shutil.rmtree(path, ignore_errors=True)

    def _write(self, generation: int, arrays: Arrays) -> None:
        target = self._folder.resolve() / str(generation)
        if target.exists():  # saved just before Ctrl-C, and asked for again after it
            return
        packed, entries = _pack(arrays)
        index = Index(
            schema=SCHEMA, generation=generation, entries=entries, digest=_digest(entries, packed)
        )
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            self._orbax.save(target, packed, custom_metadata=msgspec.to_builtins(index))
            self._prune()
        except Exception as error:  # tensorstore raises ValueError where the system has OSError
            self.discard_after(generation - 1)
            raise RunError(_save_error(generation, self._folder, error)) from error

    def _prune(self) -> None:
        if self._keep is not None:
            for generation in self.generations()[: -self._keep]:
                shutil.rmtree(self._folder / str(generation), ignore_errors=True)


def generations(folder: Path) -> list[int]:
    """Returns the generations that have a finished checkpoint in a folder, oldest first."""
    return sorted(int(path.name) for path in _listdir(folder) if path.name.isdigit())


def restore(folder: Path, generation: int) -> dict[str, npt.NDArray[Any]]:
    """Returns a generation's arrays by name, in host memory; no accelerator is used.

    Raises:
      RunError: the checkpoint is absent, of another version, cut short or changed.
    """
    path = folder.resolve() / str(generation)
    if not path.is_dir():
        raise RunError(f"there is no checkpoint of generation {generation} in {folder}")
    try:
        with ocp.PyTreeCheckpointer(use_ocdbt=False) as orbax:
            # Untyped in Orbax: checked by the conversion to Index, and by the digest below.
            metadata = cast("Any", orbax.metadata(path)).custom_metadata
            schema = metadata.get("schema") if isinstance(metadata, dict) else None
            if isinstance(schema, int) and schema != SCHEMA:
                raise RunError(
                    f"checkpoint {path} has layout version {schema} and this mjxwalk reads "
                    f"version {SCHEMA}; use the version of mjxwalk that wrote it"
                )
            index = msgspec.convert(metadata, Index)
            _check_sizes(path, index.entries)
            packed = cast("dict[str, npt.NDArray[Any]]", _restore_packed(orbax, path, index))
    except RunError:
        raise
    except Exception as error:  # Orbax passes on whatever its JSON, zarr and file layers raise
        raise RunError(f"checkpoint {path} is damaged ({_first_line(error)})") from error
    if index.generation != generation or _digest(index.entries, packed) != index.digest:
        raise RunError(f"checkpoint {path} is damaged (its contents do not match their digest)")
    return _unpack(packed, index.entries)


def restore_newest(
    folder: Path, up_to: int | None = None
) -> tuple[int, dict[str, npt.NDArray[Any]], dict[int, str]]:
    """Returns the newest generation that is whole, its arrays, and why newer ones were passed over.

    Generation 0 without arrays stands for none. Generations after `up_to` are not looked at.
    """
    damaged: dict[int, str] = {}
    for generation in reversed(generations(folder)):
        if up_to is not None and generation > up_to:
            continue
        try:
            return generation, restore(folder, generation), damaged
        except RunError as error:
            damaged[generation] = str(error)
    return 0, {}, damaged


def _restore_packed(orbax: ocp.PyTreeCheckpointer, path: Path, index: Index) -> Any:
    dtypes = {entry.dtype for entry in index.entries}
    host = {dtype: ocp.RestoreArgs(restore_type=np.ndarray) for dtype in dtypes}
    return orbax.restore(path, item=dict.fromkeys(dtypes, 0), restore_args=host)


def _check_sizes(path: Path, entries: Sequence[Entry]) -> None:
    """Refuses an index that does not fit the arrays stored, before anything is allocated."""
    for dtype, total in _totals(entries).items():
        header = msgspec.json.decode((path / dtype / ".zarray").read_bytes(), type=_ZarrHeader)
        if header.shape != (total,):
            raise ValueError(f"{dtype} holds {header.shape} numbers where the index has {total}")


class _ZarrHeader(msgspec.Struct):
    shape: tuple[int, ...]


def _totals(entries: Sequence[Entry]) -> dict[str, int]:
    totals: dict[str, int] = {}
    for entry in entries:
        totals[entry.dtype] = totals.get(entry.dtype, 0) + math.prod(entry.shape)
    return totals


def _pack(arrays: Arrays) -> tuple[dict[str, npt.NDArray[Any]], tuple[Entry, ...]]:
    pieces: dict[str, list[npt.NDArray[Any]]] = {}
    entries: list[Entry] = []
    for name, array in arrays.items():
        dtype = array.dtype.name
        pieces.setdefault(dtype, []).append(array.reshape(-1))
        entries.append(Entry(name, dtype, array.shape))
    return {dtype: np.concatenate(parts) for dtype, parts in pieces.items()}, tuple(entries)


def _unpack(packed: Arrays, entries: Sequence[Entry]) -> dict[str, npt.NDArray[Any]]:
    used = dict.fromkeys(packed, 0)
    arrays: dict[str, npt.NDArray[Any]] = {}
    for name, dtype, shape in entries:
        start, used[dtype] = used[dtype], used[dtype] + math.prod(shape)
        arrays[name] = packed[dtype][start : used[dtype]].reshape(shape)
    return arrays


def _digest(entries: Sequence[Entry], packed: Arrays) -> str:
    digest = hashlib.blake2b(msgspec.json.encode(entries), digest_size=16)
    for dtype in sorted(packed):
        digest.update(np.ascontiguousarray(packed[dtype]).data.cast("B"))
    return digest.hexdigest()


def _listdir(folder: Path) -> list[Path]:
    return list(folder.iterdir()) if folder.is_dir() else []


def _save_error(generation: int, folder: Path, error: Exception) -> str:
    text = str(error)
    full = "No space left" in text or "RESOURCE_EXHAUSTED" in text or "File too large" in text
    reason = "the disk is full" if full else _first_line(error)
    return f"generation {generation} could not be saved in {folder}: {reason}"


def _first_line(error: Exception) -> str:
    lines = str(error).strip().splitlines()
    return lines[0][:200] if lines else type(error).__name__
