"""Generations on disk: one checkpoint each, written in the background, checked when read.

A checkpoint is a flat table of named arrays in the format of Orbax. Orbax spends some 30 ms of
Python on each that it writes, a third of a short generation, so it writes only an example (see
`mjxwalk.runs.layout`), and all arrays are stored end to end as one array of bytes. An index in the
checkpoint's metadata says which piece is which, and holds a digest of the bytes.

A checkpoint counts once it has its name, and gets its name when all of it is on the disk: a loss of
power costs the generations that were under way, whatever order the disk writes in.
"""

import contextlib
import os
import shutil
import stat
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import msgspec
import numpy.typing as npt

from mjxwalk.errors import RunError
from mjxwalk.runs import files, layout, owner, packing
from mjxwalk.runs.packing import Arrays, Index

SCHEMA = 3  # of the layout; raise it whenever an older reader would misread a newer one
# Older versions, which are read as well. The first had an array for each type; neither named its
# run.
COMPRESSED = 1
UNNAMED = 2
MOST_METADATA = 1 << 24  # bytes, ours: an index of fifty arrays takes a few kilobytes


class OtherVersion(RunError):
    """A checkpoint is of a version of mjxwalk that this one does not read."""


class _Metadata(msgspec.Struct):
    custom_metadata: dict[str, Any]


class Checkpoints:
    """The checkpoints of one run, in a folder with one folder for each generation.

    Saves overlap with the next generation's work, one at a time: a second save waits for the first.
    Use it as a context manager, or call `wait` before relying on what is on disk.
    """

    def __init__(
        self, folder: Path, *, keep: int | None = None, before: Sequence[str] = ()
    ) -> None:
        """Makes no file yet.

        Args:
          folder: in that of the run; made at the first save.
          keep: newest generations that stay; None is all.
          before: files of the run that must be on the disk before a checkpoint counts.
        """
        self._folder = folder
        self._keep = keep
        self._before = before
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="checkpoint")
        self._pending: Future[None] | None = None

    def __enter__(self) -> "Checkpoints":
        return self

    def __exit__(self, *_: object) -> None:
        self._worker.shutdown(wait=True)

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
            if (_generation(path) or generation + 1) > generation:
                _remove(path)

    def _write(self, generation: int, arrays: Arrays) -> None:
        if (
            self._folder / str(generation)
        ).exists():  # saved just before Ctrl-C, and again after it
            return
        run, place = self._folder.parent, self._folder.name
        unfinished = f"{place}/{files.partial(str(generation))}"
        try:
            files.make_folder(run, place)
            content, entries = packing.pack(arrays)
            named = owner.of(run).digest
            digest = packing.digest(generation, entries, content.data, named)
            index = Index(
                schema=SCHEMA, generation=generation, entries=entries, digest=digest, run=named
            )
            for name in self._before:
                files.sync(run, name)
            files.remove(run, unfinished)
            layout.fill(run, unfinished, content, index)
            files.rename_folder(run, unfinished, str(generation))
            self._prune()
        except Exception as error:  # tensorstore raises ValueError where the system has OSError
            self.discard_after(generation - 1)
            raise RunError(_save_error(generation, self._folder, error)) from error

    def _prune(self) -> None:
        if self._keep is not None:
            for generation in self.generations()[: -self._keep]:
                _remove(self._folder / str(generation))


def generations(folder: Path) -> list[int]:
    """Returns the generations that have a finished checkpoint in a folder, oldest first."""
    return sorted(number for path in _listdir(folder) if (number := _generation(path)) is not None)


def restore(folder: Path, generation: int) -> dict[str, npt.NDArray[Any]]:
    """Returns a generation's arrays by name, in host memory; no accelerator is used.

    Nothing is allocated that is not on the disk.

    Raises:
      RunError: the checkpoint is absent, of another version, cut short or changed.
    """
    path = folder / str(generation)
    if not path.is_dir():
        raise RunError(f"there is no checkpoint of generation {generation} in {folder}")
    try:
        index = _read_index(path)
        if index.generation != generation:
            raise ValueError(f"it is of generation {index.generation}")
        owner.of(folder.parent).check(path, index.run)
        is_compressed = index.schema == COMPRESSED
        return _restore_compressed(path, index) if is_compressed else _restore(path, index)
    except OtherVersion:
        raise
    except RunError as error:
        raise RunError(f"checkpoint {path} is damaged: {error}") from error
    except Exception as error:  # Orbax passes on whatever its JSON, zarr and file layers raise
        raise RunError(f"checkpoint {path} is damaged ({_first_line(error)})") from error


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


def _read_index(path: Path) -> Index:
    _check_plain(path)
    raw = _read(path, layout.METADATA, MOST_METADATA)
    told = msgspec.json.decode(raw, type=_Metadata).custom_metadata
    schema = told.get("schema")
    if isinstance(schema, int) and schema not in (COMPRESSED, UNNAMED, SCHEMA):
        raise OtherVersion(
            f"checkpoint {path} has layout version {schema} and this mjxwalk reads version "
            f"{SCHEMA}; use the version of mjxwalk that wrote it"
        )
    return msgspec.convert(told, Index)


def _restore(path: Path, index: Index) -> dict[str, npt.NDArray[Any]]:
    wanted = packing.total(index.entries)
    content = _read(path, layout.CONTENT, wanted)
    if len(content) != wanted:
        raise ValueError(f"it holds {len(content)} bytes where the index has {wanted}")
    if packing.digest(index.generation, index.entries, content, index.run) != index.digest:
        raise ValueError("its contents do not match their digest")
    return packing.unpack(content, index.entries)


def _read(path: Path, name: str, most: int) -> bytes:
    """Returns a file of the checkpoint at a path."""
    content = files.read_inside(path.parents[1], f"{path.parent.name}/{path.name}/{name}", most)
    if content is None:
        raise ValueError(f"it has no {name}")
    return content


def _restore_compressed(path: Path, index: Index) -> dict[str, npt.NDArray[Any]]:
    from mjxwalk.runs import compressed  # imports Orbax, and with it JAX

    return compressed.restore(path, index.entries, index.digest)


def _check_plain(path: Path) -> None:
    """Refuses a checkpoint with more in it than files and folders: a link may lead anywhere."""
    if path.is_symlink():
        raise ValueError("it is a link")
    for parent, folders, names in os.walk(path):
        for name in (*folders, *names):
            mode = os.lstat(os.path.join(parent, name)).st_mode
            if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
                raise ValueError(f"{name} is no plain file")


def _generation(path: Path) -> int | None:
    """Returns the generation that a folder's name stands for."""
    name = path.name
    return int(name) if name.isascii() and name.isdecimal() and name[0] != "0" else None


def _listdir(folder: Path) -> list[Path]:
    return list(folder.iterdir()) if folder.is_dir() else []


def _remove(path: Path) -> None:
    """Removes a checkpoint; if only half of that gets done, it does not count before the rest."""
    unfinished = path.with_name(files.partial(path.name))
    if _generation(path) is not None and path.exists():
        shutil.rmtree(unfinished, ignore_errors=True)
        with contextlib.suppress(OSError):
            path = path.rename(unfinished)
    shutil.rmtree(path, ignore_errors=True)


def _save_error(generation: int, folder: Path, error: Exception) -> str:
    text = str(error)
    full = "No space left" in text or "RESOURCE_EXHAUSTED" in text or "File too large" in text
    reason = "the disk is full" if full else _first_line(error)
    return f"generation {generation} could not be saved in {folder}: {reason}"


def _first_line(error: Exception) -> str:
    lines = str(error).strip().splitlines()
    return lines[0][:200] if lines else type(error).__name__
