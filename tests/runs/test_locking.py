"""Tests of the lock of a folder, where the file system has locks and where it has none."""

import errno
from pathlib import Path

import portalocker
import pytest
import toy

from mjxwalk.cli import main
from mjxwalk.errors import RunError
from mjxwalk.runs import folder


def without(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Makes the file system answer every lock with an error."""

    def refuse(descriptor: int, operation: int) -> None:
        raise OSError(number, "refused")

    monkeypatch.setattr(portalocker.portalocker, "LOCKER", refuse)


@pytest.mark.parametrize("name", ["ENOLCK", "ENOSYS", "ENOTSUP", "EOPNOTSUPP"])
def test_a_run_goes_on_where_there_are_no_locks_and_says_so_once(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    toy.install(monkeypatch)
    without(getattr(errno, name), monkeypatch)
    path = tmp_path / name
    assert main(["evolve", "--generations", "2", "--out", str(path)]) == 0
    told = capsys.readouterr().err
    assert told == (
        f"mjxwalk: the file system of {path} has no locks; let no second process work on it\n"
    )
    assert not folder.is_locked(path)
    assert main(["list", "--runs", str(tmp_path)]) == 0


def test_a_file_system_that_fails_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / ".lock").touch()
    without(errno.EIO, monkeypatch)
    with pytest.raises(RunError, match="could not be locked: refused"), folder.locked(tmp_path):
        pass
    assert not folder.is_locked(tmp_path)
