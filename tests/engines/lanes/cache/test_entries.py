"""Kernels on disk: never another function's, harmless when damaged, nobody else's."""

import os
import stat
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mjxwalk import cache_folder
from mjxwalk.engines import lanes
from mjxwalk.engines.lanes.cache import entries

X = np.arange(6, dtype=np.float32)


def doubled(x: Any) -> Any:
    """Returns twice a number."""
    return x * 2.0


def cached(mapped: lanes.Mapped) -> bool:
    """Returns whether the code of the latest call's kernel came from the disk."""
    return mapped.compiled is not None and mapped.compiled.cached


@pytest.fixture(autouse=True)
def disk(tmp_path: Any, monkeypatch: Any) -> Any:
    """A cache of the test's own."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "mjxwalk" / "lanes"


def test_code_is_found_by_what_tracing_gives(disk: Any) -> None:
    first, second = lanes.vmap(doubled), lanes.vmap(lambda x: x + x * 1.0)
    first(X)
    np.testing.assert_array_equal(second(X), 2 * X)
    third = lanes.vmap(lambda y: y * 2.0)
    third(X)
    assert not cached(first) and cached(third)


@pytest.mark.parametrize(
    "damage", [lambda b: b[:-40], lambda b: b"", lambda b: b[:90] + b"?" + b[91:]]
)
def test_damaged_entries_are_rebuilt(disk: Any, damage: Any) -> None:
    lanes.vmap(doubled)(X)
    for path in disk.iterdir():
        path.write_bytes(damage(path.read_bytes()))
    again = lanes.vmap(doubled)
    np.testing.assert_array_equal(again(X), X * 2)
    assert not cached(again)
    last = lanes.vmap(doubled)
    last(X)
    assert cached(last)


def test_an_entry_under_another_name_is_no_entry(disk: Any) -> None:
    entries.write("name", {"a": 1}, b"code")
    os.rename(disk / "name", disk / "other")
    assert entries.read("other") is None


def test_a_disk_that_cannot_be_written_costs_no_result(monkeypatch: Any) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/proc/nowhere")
    np.testing.assert_array_equal(lanes.vmap(doubled)(X), X * 2)


def test_entries_are_written_whole(disk: Any) -> None:
    entries.write("name", {"a": 1}, b"code")
    assert entries.read("name") == ({"a": 1}, b"code")
    assert [path.name for path in Path(disk).iterdir()] == ["name"]
    assert entries.read("absent") is None


def test_the_folder_is_open_to_its_user_alone_whatever_the_umask(disk: Path) -> None:
    before = os.umask(0)
    try:
        entries.write("name", {}, b"code")
    finally:
        os.umask(before)
    for place in (disk, disk.parent):
        assert stat.S_IMODE(place.stat().st_mode) == 0o700
    assert not stat.S_IMODE((disk / "name").stat().st_mode) & 0o077


def test_a_folder_that_others_can_read_is_closed_to_them(disk: Path) -> None:
    disk.mkdir(parents=True)
    disk.chmod(0o755)
    assert cache_folder.folder("lanes") == disk
    assert stat.S_IMODE(disk.stat().st_mode) == 0o700


def _by_others(disk: Path) -> None:
    disk.chmod(0o777)


def _by_the_group(disk: Path) -> None:
    disk.parent.chmod(0o770)


def _above(disk: Path) -> None:
    disk.parent.parent.chmod(0o777)


@pytest.mark.parametrize("opened", [_by_others, _by_the_group, _above])
def test_a_folder_that_others_can_write_is_not_used(disk: Path, opened: Any, caplog: Any) -> None:
    entries.write("name", {}, b"code")
    opened(disk)
    cache_folder._warn.cache_clear()  # pyright: ignore[reportPrivateUsage]
    assert entries.read("name") is None and entries.read("name") is None
    entries.write("second", {}, b"code")
    assert not (disk / "second").exists()
    (said,) = caplog.messages  # once
    assert "keeps no compiled code on disk" in said and "XDG_CACHE_HOME" in said
    np.testing.assert_array_equal(lanes.vmap(doubled)(X), X * 2)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root gives files away")
@pytest.mark.parametrize("given", [".", "..", "name"])
def test_what_belongs_to_another_user_is_not_used(disk: Path, given: str) -> None:
    entries.write("name", {}, b"code")
    os.chown(disk / given, 12345, 12345)
    assert entries.read("name") is None


def test_an_entry_that_is_no_plain_file_is_no_entry(disk: Path) -> None:
    entries.write("name", {}, b"code")
    os.symlink("name", disk / "linked")
    os.mkfifo(disk / "pipe")
    assert entries.read("linked") is None
    assert entries.read("pipe") is None


def test_xla_keeps_nothing_in_a_folder_that_it_cannot_name(tmp_path: Path) -> None:
    program = (
        "import jax; from mjxwalk import engines; engines.prepare(); print(jax.jit(abs)(-1.0))"
    )
    env = {name: value for name, value in os.environ.items() if not name.startswith("JAX_")}
    env["XDG_CACHE_HOME"] = f"{tmp_path}/\udcff"  # a byte that is no UTF-8
    done = subprocess.run(
        [sys.executable, "-c", program], env=env, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (0, "1.0\n"), done.stderr


@pytest.mark.parametrize("base", ["relative", ""])
def test_a_relative_cache_home_is_ignored(base: str, monkeypatch: Any, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", base)
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache_folder.folder("lanes") == tmp_path / ".cache" / "mjxwalk" / "lanes"


WRITER = """
import sys, time
import numpy as np
from mjxwalk.engines import lanes
from mjxwalk.engines.lanes.cache import entries

while time.time() < float(sys.argv[1]):
    pass  # both begin at once
for turn in range(300):
    name = f"shared{turn % 3}"
    entries.write(name, {"turn": turn}, bytes([turn % 256]) * 200_000)
    entry = entries.read(name)
    assert entry is None or entry[1] == bytes([entry[0]["turn"] % 256]) * 200_000, turn
    assert entry is not None, turn
"""


def test_processes_that_write_one_entry_at_once_leave_it_whole(disk: Path) -> None:
    start = str(time.time() + 4.0)  # time to import
    crew = [
        subprocess.Popen([sys.executable, "-c", WRITER, start], stderr=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    for process in crew:
        _, errors = process.communicate(timeout=120)
        assert process.returncode == 0, errors
    assert sorted(path.name for path in disk.iterdir()) == ["shared0", "shared1", "shared2"]
