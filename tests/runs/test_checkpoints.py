"""Tests of the checkpoints: what goes in comes out, and damage is found."""

import shutil
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt
import pytest

from mjxwalk.runs import RunError, checkpoints
from mjxwalk.runs.checkpoints import Checkpoints, restore, restore_newest

# Orbax leaves its asynchronous work lying when a file of a checkpoint is damaged.
pytestmark = [
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore:coroutine:RuntimeWarning"),
]

ARRAYS: dict[str, npt.NDArray[Any]] = {
    "population.gain": np.arange(24, dtype=np.float32).reshape(4, 2, 3),
    "fitness": np.array([1.5, np.nan, -np.inf, 1e-42], np.float32),
    "mask": np.array([True, False, True]),
    "key": np.array([7, 2**32 - 1], np.uint32),
    "generation": np.asarray(3, np.int32),
}


def save(folder: Path, numbers: list[int], keep: int | None = None) -> None:
    with Checkpoints(folder, keep=keep) as writer:
        for generation in numbers:
            arrays = {**ARRAYS, "generation": np.asarray(generation, np.int32)}
            writer.save(generation, arrays)
        writer.wait()


def largest_file(folder: Path) -> Path:
    return max((p for p in folder.rglob("*") if p.is_file()), key=lambda p: p.stat().st_size)


def test_arrays_come_back_bit_for_bit(tmp_path: Path) -> None:
    save(tmp_path, [3])
    restored = restore(tmp_path, 3)
    assert list(restored) == list(ARRAYS)
    for name, array in ARRAYS.items():
        assert restored[name].dtype == array.dtype
        assert restored[name].shape == array.shape
        assert restored[name].tobytes() == array.tobytes()


def test_plain_orbax_reads_a_checkpoint(tmp_path: Path) -> None:
    save(tmp_path, [3])
    import orbax.checkpoint as ocp

    with ocp.PyTreeCheckpointer() as orbax:
        tree: Any = orbax.restore(tmp_path / "3")
    expected = b"".join(array.tobytes() for array in ARRAYS.values())
    assert tree["arrays"].tobytes() == expected


def test_the_newest_stay(tmp_path: Path) -> None:
    save(tmp_path, [1, 2, 3, 4, 5], keep=2)
    assert checkpoints.generations(tmp_path) == [4, 5]


def test_all_stay_when_none_is_to_go(tmp_path: Path) -> None:
    save(tmp_path, [1, 2, 3])
    assert checkpoints.generations(tmp_path) == [1, 2, 3]


def test_a_truncated_checkpoint_is_passed_over(tmp_path: Path) -> None:
    save(tmp_path, [1, 2])
    victim = largest_file(tmp_path / "2")
    victim.write_bytes(victim.read_bytes()[: victim.stat().st_size // 2])
    generation, arrays, damaged = restore_newest(tmp_path)
    assert generation == 1
    assert arrays["generation"] == 1
    assert list(damaged) == [2]
    assert "damaged" in damaged[2]


@pytest.mark.parametrize("file", ["arrays/0", "_CHECKPOINT_METADATA"])
def test_a_missing_file_is_found(tmp_path: Path, file: str) -> None:
    save(tmp_path, [1])
    found = next(p for p in (tmp_path / "1").rglob("*") if str(p).endswith(file))
    found.unlink()
    with pytest.raises(RunError, match="damaged"):
        restore(tmp_path, 1)


def test_flipped_bits_are_never_loaded_in_silence(tmp_path: Path) -> None:
    save(tmp_path, [1])
    good = tmp_path / "good"
    shutil.copytree(tmp_path / "1", good)
    random = np.random.default_rng(0)
    files = sorted(p.relative_to(good) for p in good.rglob("*") if p.is_file())
    weights = np.array([(good / f).stat().st_size for f in files], float)
    for _ in range(40):
        shutil.rmtree(tmp_path / "1")
        shutil.copytree(good, tmp_path / "1")
        victim = tmp_path / "1" / files[random.choice(len(files), p=weights / weights.sum())]
        content = bytearray(victim.read_bytes())
        content[random.integers(len(content))] ^= 1 << random.integers(8)
        victim.write_bytes(content)
        try:
            arrays = restore(tmp_path, 1)
        except RunError:
            continue
        # The bit was one that says nothing about the arrays, such as a time of writing.
        assert all(
            arrays[name].tobytes() == array.tobytes()
            for name, array in ARRAYS.items()
            if name != "generation"
        )


def test_another_layout_is_refused_by_its_version(tmp_path: Path) -> None:
    save(tmp_path, [1])
    file = tmp_path / "1" / "_CHECKPOINT_METADATA"
    metadata = msgspec.json.decode(file.read_bytes())
    metadata["custom_metadata"]["schema"] = 99
    file.write_bytes(msgspec.json.encode(metadata))
    with pytest.raises(RunError, match="version 99"):
        restore(tmp_path, 1)


def test_an_index_that_asks_for_more_than_is_stored_is_refused(tmp_path: Path) -> None:
    save(tmp_path, [1])
    file = tmp_path / "1" / "_CHECKPOINT_METADATA"
    metadata = msgspec.json.decode(file.read_bytes())
    metadata["custom_metadata"]["entries"][0][2] = [10**12]
    file.write_bytes(msgspec.json.encode(metadata))
    with pytest.raises(RunError, match="damaged"):
        restore(tmp_path, 1)


def test_unfinished_folders_are_not_generations(tmp_path: Path) -> None:
    save(tmp_path, [1])
    (tmp_path / ".2.partial").mkdir()
    assert checkpoints.generations(tmp_path) == [1]
    with Checkpoints(tmp_path) as writer:
        writer.discard_after(1)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["1"]


def test_a_missing_generation_is_named(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="no checkpoint of generation 5"):
        restore(tmp_path, 5)


def test_a_failed_save_is_told_and_leaves_the_older_ones(tmp_path: Path) -> None:
    folder = tmp_path / "checkpoints"
    save(folder, [1])
    moved = tmp_path / "elsewhere"
    folder.rename(moved)
    folder.write_text("in the way")
    with Checkpoints(folder) as writer:
        writer.save(2, ARRAYS)
        with pytest.raises(RunError, match="generation 2 could not be saved"):
            writer.wait()
    assert checkpoints.generations(moved) == [1]
