"""Code is trusted by its digest, in a file that nobody else can write to."""

import hashlib
import stat
from pathlib import Path

import own_tasks
import pytest

from mjxwalk import data_folder
from mjxwalk.errors import RunError
from mjxwalk.experiments.own_task import trust
from mjxwalk.runs.config import Code

SHA = hashlib.sha256(b"text").hexdigest()


def test_what_is_trusted_is_so_in_later_processes_of_this_user_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own_tasks.be("me", tmp_path, monkeypatch)
    assert not trust.is_trusted(SHA)
    trust.trust(SHA, "folder/mine.py")
    trust.trust(SHA, "folder/mine.py")
    own_tasks.be("me", tmp_path, monkeypatch)
    assert trust.is_trusted(SHA)
    assert (tmp_path / "me/mjxwalk" / trust.FILE).read_text() == f"{SHA} mine.py\n"
    own_tasks.be("another", tmp_path, monkeypatch)
    assert not trust.is_trusted(SHA)


def test_a_name_of_a_file_adds_no_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own_tasks.be("me", tmp_path, monkeypatch)
    trust.trust(SHA, f"x\n{'0' * 64} evil.py")
    assert data_folder.lines(trust.FILE) == {SHA}


def test_without_a_folder_it_is_trusted_in_this_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own_tasks.be("me", tmp_path, monkeypatch)
    (tmp_path / "me").write_text("no folder")
    trust.trust(SHA, "mine.py")
    assert trust.is_trusted(SHA)
    own_tasks.be("me", tmp_path, monkeypatch)
    assert not trust.is_trusted(SHA)


def test_the_refusal_names_file_and_digest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own_tasks.be("me", tmp_path, monkeypatch)
    with pytest.raises(RunError, match=f"task.py .made as mine.py, sha256 {SHA}.*--trust"):
        trust.check(tmp_path, Code(file="mine.py", name="TASK", sha256=SHA))


def test_the_file_is_private(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own_tasks.be("me", tmp_path, monkeypatch)
    trust.trust(SHA, "mine.py")
    file = tmp_path / "me/mjxwalk" / trust.FILE
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert stat.S_IMODE(file.parent.stat().st_mode) == 0o700
