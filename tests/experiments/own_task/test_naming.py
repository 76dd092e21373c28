"""What a user types means a file of their own, or an experiment of ours."""

from pathlib import Path

import pytest

from mjxwalk import experiments
from mjxwalk.errors import RunError
from mjxwalk.experiments import own_task


@pytest.mark.parametrize("asked", ["a.py", "b/a.py", "a.py:X", "a:X", "b.a:X", "C:\\b\\a.py", "a:"])
def test_files_and_modules_are_tasks(asked: str) -> None:
    assert own_task.is_task(asked)


def test_experiments_of_ours_are_none() -> None:
    for name in (*experiments.names(), *experiments.studies(), "", "nothing"):
        assert not own_task.is_task(name)


def test_a_file_is_found_with_its_ending_or_without(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("my task.py").write_text("", encoding="utf-8")
    named, path = own_task.find("my task.py")
    assert (named.name, named.title, path) == ("", "my-task", Path("my task.py"))
    named, path = own_task.find("my task:MINE")
    assert (named.name, named.title, path) == ("MINE", "my-task-MINE", Path("my task.py"))
    assert own_task.find("mjxwalk.robots:X")[1].name == "__init__.py"


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ("nowhere.py", "mjxwalk new task nowhere.py"),
        ("nowhere.py:X", "does not exist"),
        ("nowhere:X", "no file nowhere.py in this folder, and no module"),
        ("no.where:X", "no module no.where"),
        ("mine:", "needs a name behind its colon"),
    ],
)
def test_what_is_not_there_is_one_sentence(
    asked: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RunError, match=words):
        own_task.find(asked)
