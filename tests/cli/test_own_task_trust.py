"""A stranger's run executes nothing until the user says so."""

import json
import shutil
from pathlib import Path

import own_tasks
import pytest
from own_tasks import SMALL, TEXT

from mjxwalk import cli
from mjxwalk.runs import digests

TRAP = (
    'from pathlib import Path\n\nPath(__file__).resolve().parent.parent.joinpath("ran").touch()\n'
)
COMMANDS = [
    ["resume", "run"],
    ["watch", "run"],
    ["watch", "run", "--video", "a.gif"],
    ["report", "run"],
    ["tournament", "run"],
    ["verify", "run"],
    ["export", "run", "--to", "npz"],
    ["evolve", "planar-lpd", "--from", "run", "--out", "new"],
    ["sweep", "planar-lpd", "--from", "run", "--out", "new"],
]


@pytest.fixture(autouse=True)
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Returns the run of a stranger, whose task leaves a file where it is executed."""
    own_tasks.be("stranger", tmp_path, monkeypatch)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "theirs").mkdir()
    # A text of its own for each test, as a process executes a text once.
    text = f"{TRAP}{TEXT}\n# {tmp_path}\n"
    (tmp_path / "theirs/task.py").write_text(text, encoding="utf-8")
    assert cli.main(["evolve", "theirs/task.py", *SMALL, "--out", "run"]) == 0
    (tmp_path / "ran").unlink()
    own_tasks.be("me", tmp_path, monkeypatch)
    from mjxwalk.experiments.own_task import execution

    monkeypatch.setattr(execution, "_cache", {})
    return tmp_path / "run"


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_a_command_refuses_in_a_sentence(
    command: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    sha256 = json.loads(Path("run/config.json").read_text())["code"]["sha256"]
    capsys.readouterr()
    assert cli.main(command) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and "run/task.py" in told and sha256 in told and "--trust" in told
    assert not Path("ran").exists() and not Path("new").exists()


def test_list_needs_no_code(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["list", "--runs", "."]) == 0
    assert "generation 2 of 2" in capsys.readouterr().out and not Path("ran").exists()


def test_what_was_trusted_once_is_executed_from_then_on() -> None:
    assert cli.main(["report", "run", "--trials", "0", "--trust"]) == 0
    assert Path("ran").exists()
    assert cli.main(["tournament", "run", "--terrains", "4"]) == 0


def test_a_text_that_was_changed_is_refused_also_with_trust(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with (run / "task.py").open("a") as file:
        file.write("# one line more\n")
    assert cli.main(["resume", "run", "--trust"]) == 2
    assert "run/task.py was changed since the run was made" in capsys.readouterr().err
    assert cli.main(["resume", "run"]) == 2
    assert not Path("ran").exists()


def test_a_digest_of_another_text_executes_nothing(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The settings name a text that the user trusts, and the file holds another."""
    Path("mine.py").write_text(TEXT, encoding="utf-8")
    assert cli.main(["evolve", "mine.py", *SMALL, "--out", "mine"]) == 0
    data = json.loads((run / "config.json").read_text())
    data["code"] = json.loads(Path("mine/config.json").read_text())["code"]
    del data["digest"]
    (run / "config.json").write_bytes(digests.with_digest(data))
    assert cli.main(["resume", "run"]) == 2
    assert "was changed since the run was made" in capsys.readouterr().err
    assert not Path("ran").exists()


def test_a_run_without_its_text_is_one_sentence(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (run / "task.py").unlink()
    assert cli.main(["report", "run", "--trust"]) == 2
    assert "run lacks task.py, the text of its task task.py" in capsys.readouterr().err


def test_a_file_beside_a_strangers_text_is_not_imported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    own_tasks.be("stranger", tmp_path, monkeypatch)
    Path("theirs/helping_hand.py").write_text("SIGMA = 0.5\n", encoding="utf-8")
    Path("theirs/both.py").write_text(f"import helping_hand\n{TEXT}", encoding="utf-8")
    monkeypatch.setattr("sys.path", [*__import__("sys").path])
    assert cli.main(["evolve", "theirs/both.py", *SMALL, "--out", "both"]) == 0
    assert "imports helping_hand.py from its folder" in capsys.readouterr().err
    __import__("sys").path.remove(str(tmp_path / "theirs"))
    __import__("sys").modules.pop("helping_hand")
    shutil.copy("theirs/helping_hand.py", "both")
    own_tasks.be("me", tmp_path, monkeypatch)
    from mjxwalk.experiments.own_task import execution

    monkeypatch.setattr(execution, "_cache", {})
    assert cli.main(["report", "both", "--trust"]) == 2
    assert "PYTHONPATH" in capsys.readouterr().err


def test_a_strangers_sweep_names_no_code_to_execute(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from mjxwalk.sweep import plan as plans

    file = str(tmp_path / "theirs/task.py")
    resources = plans.Resources(
        executor="local", cores=1, memory_gb=None, address=None, partition=None, hours=24.0
    )
    for name, more in (("a", []), ("b", ["--task-sha256", "0" * 64])):
        plans.create(tmp_path / name, plans.make({"seed-0": [file, *more]}, resources))
        assert cli.main(["resume", name]) == 2
        assert "theirs/task.py" in capsys.readouterr().err
    trusting = [file, "--from", "run", "--trust"]
    plans.create(tmp_path / "c", plans.make({"seed-0": trusting}, resources))
    assert cli.main(["resume", "c", "--trust"]) == 2
    assert "what a sweep does not" in capsys.readouterr().err
    assert not Path("ran").exists()
