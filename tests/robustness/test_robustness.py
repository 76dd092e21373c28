"""A few of the kills and mutations that `docs/robustness.md` has figures of, and files to fear."""

import io
import os
import resource
import struct
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import toy
from robustness import killing, mutating

from mjxwalk import runs
from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.runs import RunError, config, files, npz, result


@pytest.fixture(autouse=True)
def toy_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    toy.install(monkeypatch)


def test_mutated_runs_are_refused_or_read_as_what_they_were(tmp_path: Path) -> None:
    counts = mutating.attack(40, seed=1, place=tmp_path, resume_every=20)
    assert counts["refused"] + counts["damaged"] > 8
    assert counts["same"] > 5


@pytest.mark.slow
def test_runs_killed_at_random_instants_resume_to_the_same_bits(tmp_path: Path) -> None:
    # In a process of its own: it forks, which one in which JAX has threads must not.
    code = f"""
import pathlib, pytest, toy, killing
toy.install(pytest.MonkeyPatch())
assert killing.attack(5, 2, pathlib.Path({str(tmp_path)!r}))[0] >= 5
"""
    killing.in_new_process(code)


@pytest.fixture
def little_memory() -> Iterator[None]:
    """Lets the process take 2 GB more than it has: a reader that trusts a header wants more."""
    limits = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * os.sysconf("SC_PAGE_SIZE") + 2**31
    resource.setrlimit(resource.RLIMIT_AS, (most, limits[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, limits)


def npy(header: str, data: bytes = b"") -> bytes:
    text = header.ljust(117).encode() + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + data


def archive(compression: int = zipfile.ZIP_STORED, **members: bytes) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", compression) as zipped:
        for name, content in members.items():
            zipped.writestr(f"{name}.npy", content)
    return buffer.getvalue()


def overlapping() -> bytes:
    """Returns an archive whose directory has one member two hundred times."""
    content = archive(
        gain=npy("{'descr': '|u1', 'fortran_order': False, 'shape': (9999,)}", b"9" * 9999)
    )
    start = content.index(b"PK\x01\x02")
    end = content.index(b"PK\x05\x06")
    entries = content[start:end] * 200
    fields = list(struct.unpack("<4s4H2LH", content[end : end + 22]))
    fields[3] = fields[4] = 200
    fields[5] = len(entries)
    return content[:start] + entries + struct.pack("<4s4H2LH", *fields)


ENORMOUS = "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,)}"
OBJECTS = "{'descr': '|O', 'fortran_order': False, 'shape': (1,)}"


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (archive(gain=npy(ENORMOUS, b"12345678")), "it holds 8 bytes for"),
        (archive(zipfile.ZIP_DEFLATED, gain=bytes(2**28)), "it is compressed"),
        (overlapping(), "its members overlap"),
        (archive(gain=npy(OBJECTS, b"\x80\x04.")), "which are not plain numbers"),
        (archive(gain=npy("__import__('os').abort()")), "malformed node"),
        (
            archive(gain=npy("{'descr': '<f4', 'fortran_order': False, 'shape': (-1,)}")),
            "bytes for",
        ),
        (b"PK\x03\x04", "File is not a zip file"),
        (b"", "File is not a zip file"),
    ],
)
def test_an_archive_that_is_a_trap_is_one_sentence(
    tmp_path: Path, little_memory: None, content: bytes, reason: str
) -> None:
    path = tmp_path / result.CHAMPION_FILE
    path.write_bytes(content)
    with pytest.raises(RunError, match=reason) as caught:
        result.read_genotype(tmp_path)
    assert "\n" not in str(caught.value)


def test_arrays_of_every_layout_come_back(tmp_path: Path) -> None:
    arrays: dict[str, Any] = {
        "fortran": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        "scalar": np.asarray(True),
        "empty": np.zeros((0, 4), np.int8),
        "file": np.arange(3, dtype=np.uint32),
    }
    (tmp_path / "a.npz").write_bytes(npz.npz(arrays))
    found = npz.read_npz(tmp_path / "a.npz")
    np.testing.assert_equal(found, arrays)
    with np.load(tmp_path / "a.npz", allow_pickle=False) as plain:
        np.testing.assert_equal(dict(plain), arrays)


def test_json_of_a_million_layers_is_one_sentence(tmp_path: Path) -> None:
    run_config.create(tmp_path / "a", Config(experiment=toy.Toy()))
    (tmp_path / "a" / config.FILE).write_bytes(b'{"schema":' + b"[" * 10**6 + b"]" * 10**6 + b"}")
    with pytest.raises(RunError, match="config.json cannot be read"):
        runs.load(tmp_path / "a")


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.json")
    with pytest.raises(RunError, match="it is no plain file"):
        files.read(tmp_path / "a.json")


def test_a_file_that_never_ends_is_not_read_to_its_end(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    with path.open("wb") as file:
        file.truncate(2**40)  # a terabyte of zeros that takes no room
    with pytest.raises(RunError, match="it has more than"):
        files.read(path, 1000)


def test_nothing_here_opens_pickles() -> None:
    root = Path(runs.__file__).parents[1]
    sources = [
        path for place in (".", "envs", "strategies") for path in (root / place).rglob("*.py")
    ]
    assert len(sources) > 100
    for path in sources:
        text = path.read_text()
        for word in ("import pickle", "import dill", "import shelve", "marshal.load"):
            assert word not in text, f"{path} has {word}"
        assert "np.load(" not in text and "allow_pickle=True" not in text, path
