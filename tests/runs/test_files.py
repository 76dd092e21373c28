"""Tests of reading and writing files of a run: how much memory it takes, and what is left."""

import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mjxwalk.runs import RunError, files, npz

SMALL, LARGE = 1_000, 10_000_000


@pytest.mark.parametrize("size", [SMALL, LARGE])
def test_reading_takes_the_memory_of_what_is_there(tmp_path: Path, size: int) -> None:
    (tmp_path / "text").write_bytes(bytes(size))
    arrays = {"a": np.zeros(size, np.uint8)}
    (tmp_path / "a.npz").write_bytes(npz.npz(arrays))
    reads: list[tuple[Callable[[], object], int]] = [
        (lambda: files.read(tmp_path / "text"), 1),
        (lambda: files.read_inside(tmp_path, "text"), 1),
        (lambda: npz.read_npz(tmp_path / "a.npz"), 4),  # the file, its member, the numbers, a copy
    ]
    for read, copies in reads:
        tracemalloc.start()
        read()
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < copies * size + 200_000


def test_a_file_that_is_too_large_is_refused_before_it_is_read(tmp_path: Path) -> None:
    with (tmp_path / "a").open("wb") as file:
        file.truncate(2**40)
    tracemalloc.start()
    with pytest.raises(RunError, match="it has more than 1000 bytes"):
        files.read_inside(tmp_path, "a", 1000)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 200_000


def test_a_file_that_is_not_there_is_none_and_its_end_is_empty(tmp_path: Path) -> None:
    assert files.read_inside(tmp_path, "a") is None
    assert files.read_inside(tmp_path, "no/folder/a") is None
    assert files.read_end(tmp_path, "a", 10) == b""
    (tmp_path / "a").write_bytes(b"0123456789")
    assert files.read_end(tmp_path, "a", 4) == b"6789"
    assert files.read_end(tmp_path, "a", 40) == b"0123456789"


def test_lines_are_added_and_folders_made_and_removed(tmp_path: Path) -> None:
    files.append_line(tmp_path, "a", b"one")
    files.append_line(tmp_path, "a", b"two")
    assert (tmp_path / "a").read_bytes() == b"one\ntwo\n"
    files.make_folder(tmp_path, "b/c")
    files.make_folder(tmp_path, "b/c")
    files.create(tmp_path, "b/c/d", b"")
    files.remove(tmp_path, "b")
    files.remove(tmp_path, "a")
    files.remove(tmp_path, "a")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_the_place_of_a_file_stays(tmp_path: Path) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    with pytest.raises(RunError, match="what is there is no plain file"):
        files.replace(tmp_path, "a", b"")
    assert (tmp_path / "a" / "b").is_dir()
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
