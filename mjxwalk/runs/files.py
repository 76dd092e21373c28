"""Files in the folder of a run, a study or a sweep, which may come from anybody.

They are replaced whole, appended to by the line, and read within limits. All goes through `way`,
which follows no link inside the folder: what is written to a link lands wherever whoever made the
folder wanted it. The folder itself is the user's to name, and may be a link.
"""

import contextlib
import io
import os
import shutil
import stat
from collections.abc import Generator
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

import msgspec

from mjxwalk import depth, open_flags
from mjxwalk.errors import RunError
from mjxwalk.runs import way

T = TypeVar("T")

# What msgspec raises where bytes are not the JSON that they should be; the last of too many layers.
MALFORMED = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)

MOST_BYTES = 1 << 28  # ours: of a file with text; the figures of 300,000 generations take as much
MOST_JSON = 1 << 24  # ours: of a JSON file; read into tables, it takes some twenty times as much


def replace(folder: Path, name: str, content: bytes) -> None:
    """Writes a file so that a reader finds the old content or the new, never a part.

    Args:
      folder: that the file is in.
      name: of the file, with the folders between.
      content: of the file.

    Raises:
      RunError: the disk is full, the folder cannot be written, or a link or no file is in the way.
    """
    path = folder / name
    with _told("written", path), way.follow(folder, name) as (place, last):
        unfinished = partial(last)
        try:
            _check_replaceable(path, way.lstat(last, place))
            _discard(unfinished, place)
            with _created(unfinished, place) as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            os.replace(unfinished, last, src_dir_fd=place, dst_dir_fd=place)
            way.sync_folder(place)
        except OSError:
            with contextlib.suppress(OSError):  # a folder that cannot be written
                _discard(unfinished, place)
            raise


def create(folder: Path, name: str, content: bytes | memoryview) -> None:
    """Writes a file that was not there, and returns when it is on the disk.

    Raises:
      OSError: the disk is full, or something of the name is there.
      RunError: a link is in the way.
    """
    with way.follow(folder, name) as (place, last), _created(last, place) as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def open_append(folder: Path, name: str) -> io.FileIO:
    """Returns a file to add to at its end; it is made if it is not there.

    Raises:
      RunError: it cannot be written, or is a link, no plain file, or a file with a second name.
    """
    path = folder / name
    flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT
    with _told("written", path), way.follow(folder, name) as (place, last):
        descriptor = way.opened(last, flags, place, path)
        if os.fstat(descriptor).st_nlink > 1:
            os.close(descriptor)
            raise RunError(
                f"{path} could not be written: it has a second name (a hard link), under which it "
                "would change as well; put a copy in its place"
            )
        return open(descriptor, "ab", buffering=0)


def append_line(folder: Path, name: str, line: bytes) -> None:
    """Adds a line to a file.

    Raises:
      RunError: the disk is full, or the file cannot be written.
    """
    with open_append(folder, name) as file, _told("written", folder / name):
        content = memoryview(line + b"\n")
        while content:  # a disk that is nearly full takes a part
            content = content[file.write(content) :]


def make_folder(folder: Path, name: str) -> None:
    """Makes a folder inside another, and those between; it may be there.

    Raises:
      RunError: it cannot be made, or a link or a file is in the way.
    """
    with _told("made", folder / name), way.follow(folder, f"{name}/.", is_made=True):
        pass


def rename_folder(folder: Path, name: str, new: str) -> None:
    """Gives a folder its name, and returns when it has it on the disk.

    Raises:
      OSError: the new name is taken.
      RunError: a link is in the way.
    """
    with way.follow(folder, name) as (place, last):
        new = os.path.join(os.path.dirname(last), new)
        os.replace(last, new, src_dir_fd=place, dst_dir_fd=place)
        way.sync_folder(place)


def remove(folder: Path, name: str) -> None:
    """Removes a file or a folder with all in it, if it is there.

    Raises:
      RunError: it cannot be removed, or a link is in the way.
    """
    with _told("removed", folder / name), way.follow(folder, name) as (place, last):
        found = way.lstat(last, place)
        if found is not None and stat.S_ISDIR(found.st_mode):
            shutil.rmtree(last, dir_fd=place)
        elif found is not None:
            os.unlink(last, dir_fd=place)


def sync(folder: Path, name: str) -> None:
    """Returns when what was written to a file, or which names a folder has, is on the disk itself.

    Raises:
      OSError: the system cannot tell.
      RunError: a link is in the way.
    """
    with way.follow(folder, name) as (place, last):
        if place is None:  # Windows syncs what can be written; a crash of it can lose this
            return
        flags = os.O_RDONLY | open_flags.NO_LINK | open_flags.NO_WAITING
        descriptor = os.open(last, flags, dir_fd=place)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def check_writable(folder: Path, hint: str = "") -> None:
    """Raises RunError unless files can be made in a folder.

    Args:
      folder: that is there.
      hint: what to do otherwise.
    """
    if not os.access(folder, os.W_OK | os.X_OK):
        raise RunError(f"{folder} cannot be written: permission denied{hint}")


def partial(name: str) -> str:
    """Returns what a file is called, or its path, while its content is being written."""
    folder, last = os.path.split(name)
    return os.path.join(folder, f".{last}.partial")


def read(path: Path, most: int = MOST_BYTES) -> bytes:
    """Returns the content of a file that the user named, which may be a link.

    Raises:
      RunError: it cannot be read, has more than so many bytes, or is no plain file, such as a pipe.
    """
    with _told("read", path):
        descriptor = way.opened(path, os.O_RDONLY, None, path, may_be_link=True)
        return _content(descriptor, path, most)


def read_inside(folder: Path, name: str, most: int = MOST_BYTES) -> bytes | None:
    """Returns the content of a file in a folder, None if it is not there.

    Raises:
      RunError: it cannot be read, has more than so many bytes, is a link, or is no plain file.
    """
    path = folder / name
    try:
        with _told("read", path), way.follow(folder, name) as (place, last):
            return _content(way.opened(last, os.O_RDONLY, place, path), path, most)
    except _NotThere:
        return None


def read_end(folder: Path, name: str, length: int) -> bytes:
    """Returns the last bytes of a file in a folder, b"" of one that is not there or cannot be read.

    Args:
      folder: that the file is in.
      name: of the file.
      length: bytes at most.
    """
    path = folder / name
    try:
        with _told("read", path), way.follow(folder, name) as (place, last):
            with open(way.opened(last, os.O_RDONLY, place, path), "rb") as file:
                file.seek(max(0, os.fstat(file.fileno()).st_size - length))
                return file.read(length)
    except RunError:
        return b""


def decode(path: Path, content: bytes, kind: type[T]) -> T:
    """Returns what the content of a JSON file holds.

    Args:
      path: of the file, for the complaint.
      content: of the file.
      kind: what it must hold.

    Raises:
      RunError: it holds something else, or has too many layers.
    """
    try:
        return msgspec.json.decode(content, type=kind)
    except MALFORMED as error:
        raise RunError(f"{path} cannot be read: {error}") from None


def decode_table(path: Path, content: bytes) -> dict[str, Any]:
    """Returns what the content of a JSON file with a table holds; the arguments are `decode`'s.

    Raises:
      RunError: it holds something else, or has too many layers.
    """
    try:
        table = msgspec.json.decode(content, type=dict[str, Any])
    except MALFORMED as error:
        raise RunError(f"{path} cannot be read: {error}") from None
    if depth.is_deep(table):
        raise RunError(f"{path} cannot be read: it has more than {depth.MOST} layers")
    return table


def describe(error: OSError) -> str:
    """Returns why the system refused, in a few words."""
    return (error.strerror or str(error)).lower()


class _NotThere(RunError):
    """A file is not there."""


@contextlib.contextmanager
def _told(done: str, path: Path) -> Generator[None]:
    """Turns what the system refuses into a sentence on a file."""
    try:
        yield
    except OSError as error:
        kind = _NotThere if isinstance(error, FileNotFoundError) else RunError
        raise kind(f"{path} could not be {done}: {describe(error)}") from error


def _check_replaceable(path: Path, found: os.stat_result | None) -> None:
    """Raises RunError unless there is a plain file or nothing at a path."""
    way.check_no_link(path, found)
    if found is not None and not stat.S_ISREG(found.st_mode):
        raise RunError(f"{path} could not be written: what is there is no plain file")


def _created(name: str, place: int | None) -> BinaryIO:
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | open_flags.NO_LINK
    return open(os.open(name, flags, 0o666, dir_fd=place), "wb")


def _discard(name: str, place: int | None) -> None:
    with contextlib.suppress(FileNotFoundError):
        os.unlink(name, dir_fd=place)


def _content(descriptor: int, path: Path, most: int) -> bytes:
    # Without a buffer, and so without more memory than the file has bytes.
    with open(descriptor, "rb", buffering=0) as file:
        content = b""
        if (size := os.fstat(descriptor).st_size) <= most:
            content = file.readall()
        if max(size, len(content)) > most:
            raise RunError(f"{path} could not be read: it has more than {most} bytes")
        return content
