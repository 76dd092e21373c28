"""Kernels on disk: found before tracing, never wrong, harmless when damaged."""

import dataclasses
import functools
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.engines import lanes
from mjxwalk.engines.lanes import cache, identity

X = np.arange(6, dtype=np.float32)


class Answer(NamedTuple):
    """An output tree that has to survive the disk."""

    twice: np.ndarray
    rest: dict[str, list[np.ndarray | None]]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Task:
    """Settings that a kernel depends on."""

    factor: float = 2.0

    def run(self, x: Any) -> Any:
        """Returns a tree of every kind."""
        return Answer(x * self.factor, {"a": [x, None]})


def cached(mapped: lanes.Mapped) -> bool:
    """Returns whether the kernel of the latest call came from the disk."""
    return mapped.compiled is not None and mapped.compiled.cached


@pytest.fixture(autouse=True)
def disk(tmp_path: Any, monkeypatch: Any) -> Any:
    """A cache of the test's own."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "mjxwalk" / "lanes"


def test_second_process_finds_the_kernel_without_tracing(disk: Any) -> None:
    first, second = lanes.vmap(Task().run), lanes.vmap(Task().run)
    one, two = first(X), second(X)
    assert not cached(first) and cached(second)
    assert isinstance(two, Answer)
    np.testing.assert_array_equal(one.twice, two.twice)
    assert two.rest["a"][1] is None


def test_other_settings_are_another_kernel() -> None:
    np.testing.assert_array_equal(lanes.vmap(Task(factor=3.0).run)(X).twice, X * 3)
    np.testing.assert_array_equal(lanes.vmap(Task(factor=4.0).run)(X).twice, X * 4)


def test_closed_over_values_are_part_of_the_function() -> None:
    def add(amount: Any) -> Any:
        return lambda x: x + amount

    np.testing.assert_array_equal(lanes.vmap(add(1.0))(X), X + 1)
    np.testing.assert_array_equal(lanes.vmap(add(2.0))(X), X + 2)
    np.testing.assert_array_equal(lanes.vmap(add(np.float32(5)))(X), X + 5)
    np.testing.assert_array_equal(lanes.vmap(functools.partial(jnp.add, 3.0))(X), X + 3)


@pytest.mark.parametrize(
    "damage", [lambda b: b[:-40], lambda b: b"", lambda b: b[:90] + b"?" + b[91:]]
)
def test_damaged_entries_are_rebuilt(disk: Any, damage: Any) -> None:
    lanes.vmap(Task().run)(X)
    for path in disk.iterdir():
        path.write_bytes(damage(path.read_bytes()))
    again = lanes.vmap(Task().run)
    np.testing.assert_array_equal(again(X).twice, X * 2)
    assert not cached(again)
    last = lanes.vmap(Task().run)
    last(X)
    assert cached(last)


def test_a_changed_source_file_is_traced_again(disk: Any, tmp_path: Any, monkeypatch: Any) -> None:
    source = tmp_path / "settings_of_a_walker.txt"
    source.write_text("1")
    found = identity.manifest(set())
    assert found is not None and identity.holds(found)
    recorded = found | {str(source): [source.stat().st_size, source.stat().st_mtime_ns]}
    assert identity.holds(recorded)
    source.write_text("12")
    assert not identity.holds(recorded)


def test_a_disk_that_cannot_be_written_costs_no_result(monkeypatch: Any) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/proc/nowhere")
    np.testing.assert_array_equal(lanes.vmap(Task().run)(X).twice, X * 2)


def test_entries_are_written_whole(disk: Any) -> None:
    cache.write("name", {"a": 1}, b"code")
    assert cache.read("name") == ({"a": 1}, b"code")
    assert [path.name for path in Path(disk).iterdir()] == ["name"]
    assert cache.read("absent") is None


def test_objects_without_a_text_are_not_named() -> None:
    class Opaque:
        pass

    with pytest.raises(identity.Unnamed):
        identity.Identity().text(Opaque())


WRITER = """
import sys, time
import numpy as np
from mjxwalk.engines import lanes
from mjxwalk.engines.lanes import cache

while time.time() < float(sys.argv[1]):
    pass  # both begin at once
for turn in range(300):
    name = f"shared{turn % 3}"
    cache.write(name, {"turn": turn}, bytes([turn % 256]) * 200_000)
    entry = cache.read(name)
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
