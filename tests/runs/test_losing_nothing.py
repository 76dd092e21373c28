"""Tests of what may happen to a run's files: lost power, damage, other versions, two processes."""

import errno
import hashlib
import itertools
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import orbax.checkpoint as ocp
import pytest
import toy

from mjxwalk import runs
from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.runs import RunError, checkpoints, config, digests, folder, metrics
from mjxwalk.runs.checkpoints import Checkpoints

ARRAYS = {
    "population": np.arange(24, dtype=np.float32).reshape(4, 6),
    "mask": np.array([True, False, True]),
    "other": np.full((2, 2), 0.1, np.float32),
    "generation": np.asarray(1, np.int32),
}


@pytest.fixture(autouse=True)
def toy_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    toy.install(monkeypatch)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("runs") / "finished"
    settings = Config(experiment=toy.Toy(), keep=3)
    run_config.create(path, settings)
    toy.evolve(path, settings)
    return path


@pytest.fixture
def stopped(finished: Path, tmp_path: Path) -> Path:
    """A copy of the run as a kill after its last checkpoint would leave it."""
    path = tmp_path / "stopped"
    shutil.copytree(finished, path)
    (path / "result.json").unlink()
    (path / "champion.npz").unlink()
    return path


def resume(path: Path) -> list[str]:
    settings = run_config.read(path)
    silent = toy.Silent()
    toy.evolve(path, settings, silent)
    return silent.said


def state(path: Path) -> dict[str, bytes]:
    return {name: array.tobytes() for name, array in runs.load(path).arrays.items()}


def test_all_of_a_checkpoint_is_on_the_disk_before_it_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    figures = tmp_path / "metrics.jsonl"
    figures.write_text("a line\n")
    with Checkpoints(tmp_path / "c", before=(figures.name,)) as writer:
        writer.save(1, ARRAYS)  # makes the example
        writer.wait()
        events: list[tuple[str, str]] = []
        fsync, replace = os.fsync, os.replace

        def noting_fsync(descriptor: int) -> None:
            events.append(("fsync", os.readlink(f"/proc/self/fd/{descriptor}")))
            fsync(descriptor)

        def noting_replace(source: str, target: str, *, src_dir_fd: int, dst_dir_fd: int) -> None:
            events.append(("rename", f"{os.readlink(f'/proc/self/fd/{dst_dir_fd}')}/{target}"))
            replace(source, target, src_dir_fd=src_dir_fd, dst_dir_fd=dst_dir_fd)

        monkeypatch.setattr(os, "fsync", noting_fsync)
        monkeypatch.setattr(os, "replace", noting_replace)
        writer.save(2, ARRAYS)
        writer.wait()
    named = events.index(("rename", str(tmp_path / "c" / "2")))
    before = {path for what, path in events[:named] if what == "fsync"}
    inside = {str(p.relative_to(tmp_path / "c/2")) for p in (tmp_path / "c/2").rglob("*")}
    unfinished = tmp_path / "c" / ".2.partial"
    assert {str(unfinished / name) for name in inside} | {str(unfinished)} <= before
    assert str(figures) in before
    assert events[named + 1] == ("fsync", str(tmp_path / "c"))


def test_a_checkpoint_is_removed_under_another_name_first(tmp_path: Path) -> None:
    with Checkpoints(tmp_path, keep=1) as writer:
        for generation in (1, 2):
            writer.save(generation, ARRAYS)
        writer.wait()
    assert [path.name for path in tmp_path.iterdir()] == ["2"]


def old_checkpoint(path: Path, **changes: Any) -> None:
    """Writes one as version 1 of the layout did, by Orbax alone."""
    by_type: dict[str, list[Any]] = {}
    for array in ARRAYS.values():
        by_type.setdefault(array.dtype.name, []).append(array.ravel())
    packed = {name: np.concatenate(pieces) for name, pieces in by_type.items()}
    entries = [[name, array.dtype.name, list(array.shape)] for name, array in ARRAYS.items()]
    digest = hashlib.blake2b(msgspec.json.encode(entries), digest_size=16)
    for name in sorted(packed):
        digest.update(packed[name].tobytes())
    told = {"schema": 1, "generation": 1, "entries": entries, "digest": digest.hexdigest()}
    with ocp.PyTreeCheckpointer(use_ocdbt=False) as orbax:
        orbax.save(path / "1", packed, custom_metadata=told | changes)


@pytest.mark.parametrize("inside", [False, True], ids=["absolute", "from a folder in it"])
def test_a_checkpoint_of_the_older_layout_reads_to_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, inside: bool
) -> None:
    old_checkpoint(tmp_path / "c")
    monkeypatch.chdir(tmp_path / "c")
    found = checkpoints.restore(Path("../c") if inside else tmp_path / "c", 1)
    assert list(found) == list(ARRAYS)
    for name, array in ARRAYS.items():
        assert (found[name].dtype, found[name].shape) == (array.dtype, array.shape)
        assert found[name].tobytes() == array.tobytes()


def test_an_older_checkpoint_that_would_swell_is_refused_unread(tmp_path: Path) -> None:
    many = 1 << 27  # times 4 bytes: half a gigabyte of zeros, which are 50 kB compressed
    entries = [["population", "float32", [many]]]
    with ocp.PyTreeCheckpointer(use_ocdbt=False) as orbax:
        told = {"schema": 1, "generation": 1, "entries": entries, "digest": ""}
        orbax.save(tmp_path / "1", {"float32": np.zeros(64, np.float32)}, custom_metadata=told)
    with pytest.raises(RunError, match="asks for 536870912 bytes"):
        checkpoints.restore(tmp_path, 1)
    # An index that fits its header, and a frame that holds more than both say.
    shutil.rmtree(tmp_path / "1")
    old_checkpoint(tmp_path)
    chunk = tmp_path / "1" / "float32" / "0"
    content = bytearray(chunk.read_bytes())
    assert content[:4].hex() == "28b52ffd" and content[4] == 0x20  # one byte tells the size
    content[5] = 255
    chunk.write_bytes(content)
    with pytest.raises(RunError, match="float32 would not come out of its compression"):
        checkpoints.restore(tmp_path, 1)


@pytest.mark.parametrize("place", ["checkpoints/6/arrays/0", "checkpoints/6", "metrics.jsonl"])
def test_a_link_out_of_the_folder_is_not_followed(
    stopped: Path, tmp_path: Path, place: str
) -> None:
    inside, outside = stopped / place, tmp_path / "outside"
    inside.rename(outside)
    inside.symlink_to(outside)
    before = sorted(outside.rglob("*")), outside.stat().st_mtime_ns
    with pytest.raises(RunError, match="is a link, which can lead out of the folder"):
        runs.load(stopped)
    with pytest.raises(RunError, match="is a link"), folder.locked(stopped):
        resume(stopped)
    assert before == (sorted(outside.rglob("*")), outside.stat().st_mtime_ns)


@pytest.mark.parametrize("name", ["²", "007", "9" * 250, "nine", "0"])
def test_a_folder_that_is_named_like_no_generation_is_none(stopped: Path, name: str) -> None:
    (stopped / "checkpoints" / name).mkdir()
    loaded = runs.load(stopped)
    assert loaded.generation == 6
    assert loaded.generations in ([4, 5, 6], [4, 5, 6, int("9" * 250)])


def test_figures_cut_in_their_middle_cost_generations_and_no_checkpoint(
    finished: Path, stopped: Path
) -> None:
    file = stopped / metrics.FILE
    lines = file.read_bytes().splitlines(keepends=True)
    file.write_bytes(b"".join(lines).replace(b'"generation":6', b'"generation":9'))
    assert resume(stopped)[0] == "going on from generation 5"
    assert state(stopped) == state(finished)
    # Figures older than any checkpoint: starting anew would throw away what there is.
    (stopped / "result.json").unlink()
    file.write_bytes(b"".join(lines[:2]))
    with pytest.raises(RunError, match="metrics.jsonl ends after generation 2, before the oldest"):
        resume(stopped)
    assert checkpoints.generations(stopped / "checkpoints") == [4, 5, 6]


def test_a_flipped_bit_in_a_line_of_figures_is_found(finished: Path, tmp_path: Path) -> None:
    shutil.copy(finished / config.FILE, tmp_path)
    line = (finished / metrics.FILE).read_bytes().splitlines()[0]
    for place, bit in itertools.product(range(0, len(line), 3), (0, 2)):
        changed = bytearray(line)
        changed[place] ^= 1 << bit
        (tmp_path / metrics.FILE).write_bytes(changed + b"\n")
        assert metrics.read(tmp_path) == []
    (tmp_path / metrics.FILE).write_bytes(line + b"\n")
    assert len(metrics.read(tmp_path)) == 1


def test_figures_of_older_versions_have_no_checksum(finished: Path, tmp_path: Path) -> None:
    line = (finished / metrics.FILE).read_bytes().splitlines()[0]
    (tmp_path / metrics.FILE).write_bytes(line[: line.index(b',"run"')] + b"}\n")
    assert metrics.read(tmp_path) == metrics.read(finished)[:1]


def test_a_file_with_a_digest_may_be_laid_out_anew_and_not_changed(tmp_path: Path) -> None:
    content = digests.with_digest({"speed": 0.1, "table": {"one": [1, None]}})
    path = tmp_path / "a.json"
    digests.check(path, msgspec.json.format(content, indent=-1), needed=True)
    for old, new in ((b"0.1", b"0.2"), (b"one", b"two"), (b"null", b"true")):
        with pytest.raises(RunError, match="was changed since it was written"):
            digests.check(path, content.replace(old, new), needed=True)
    digests.check(path, b'{"speed": 0.1}', needed=False)
    with pytest.raises(RunError, match="was changed"):
        digests.check(path, b'{"speed": 0.1}', needed=True)


def test_a_clock_that_is_put_back_changes_nothing(
    finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = itertools.count(10**18, -(10**14))  # a day earlier at each look
    monkeypatch.setattr(time, "time_ns", lambda: next(clock))
    monkeypatch.setattr(time, "time", lambda: next(clock) / 1e9)
    path = tmp_path / "a"
    run_config.create(path, run_config.read(finished))
    resume(path)
    assert state(path) == state(finished)
    assert (runs.load(path).metrics["other_s"] >= 0).all()


def test_a_time_that_comes_again_gives_another_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Stopped(folder.datetime.datetime):
        """A clock that stands still."""

        @classmethod
        def now(cls, tz: Any = None) -> Any:
            """Returns the same time always."""
            return cls(2026, 1, 2, 3, 4, 5, tzinfo=tz)

    monkeypatch.setattr(folder.datetime, "datetime", Stopped)
    monkeypatch.chdir(tmp_path)
    paths: list[str] = []
    for _ in range(3):
        path = folder.default_path("toy", 1)
        path.mkdir(parents=True)
        paths.append(path.name)
    first = "toy-1-20260102-030405"
    assert paths == [first, f"{first}-2", f"{first}-3"]


def test_of_two_processes_that_begin_in_one_folder_one_is_refused(tmp_path: Path) -> None:
    with folder.locked(tmp_path), pytest.raises(RunError, match="another process is working on"):
        run_config.create(tmp_path, Config(experiment=toy.Toy()))
    assert not (tmp_path / config.FILE).exists()
    run_config.create(tmp_path, Config(experiment=toy.Toy()))


def test_a_killed_process_leaves_no_lock(tmp_path: Path) -> None:
    code = f"""
import pathlib, sys, time
from mjxwalk.runs import folder
with folder.locked(pathlib.Path({str(tmp_path)!r})):
    print("locked", flush=True)
    time.sleep(60)
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "locked\n"
    assert folder.is_locked(tmp_path)
    process.kill()
    process.communicate()
    with folder.locked(tmp_path):
        pass


def test_a_folder_that_cannot_be_written_is_one_sentence(
    stopped: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = os.open

    def refuse(path: Any, flags: int, *args: Any, **kwargs: Any) -> int:
        if flags & (os.O_WRONLY | os.O_RDWR):
            raise OSError(errno.EROFS, os.strerror(errno.EROFS))
        return opened(path, flags, *args, **kwargs)

    monkeypatch.setattr(os, "open", refuse)
    with (
        pytest.raises(RunError, match=r"stopped cannot be written: read-only file system"),
        folder.locked(stopped),
    ):
        pass
    assert runs.load(stopped).generation == 6
