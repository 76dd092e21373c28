"""`mjxwalk new` writes files that evolve, and replaces none; the document's task evolves too."""

import re
from pathlib import Path

import own_tasks
import pytest

from mjxwalk import cli
from mjxwalk.experiments.own_task import examples

DOCUMENT = Path(__file__).parents[2] / "docs" / "own-task.md"


@pytest.fixture(autouse=True)
def _user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:  # pyright: ignore
    own_tasks.be("me", tmp_path, monkeypatch)
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("kind", examples.KINDS)
def test_an_example_is_written_once(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["new", kind, "mine.py"]) == 0
    assert "mjxwalk evolve mine.py" in capsys.readouterr().out
    text = Path("mine.py").read_text(encoding="utf-8")
    assert text == examples.text(kind)
    Path("mine.py").write_text("mine\n", encoding="utf-8")
    assert cli.main(["new", kind, "mine.py"]) == 2
    assert "mine.py is there already" in capsys.readouterr().err
    assert Path("mine.py").read_text(encoding="utf-8") == "mine\n"


@pytest.mark.parametrize("file", ["mine", "mine.txt", "nowhere/mine.py"])
def test_a_file_that_cannot_be_is_one_sentence(
    file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["new", "task", file]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.slow
@pytest.mark.parametrize("kind", examples.KINDS)
def test_an_example_evolves_for_two_generations(kind: str) -> None:
    assert cli.main(["new", kind, "mine.py"]) == 0
    small = ["--generations", "2", "--population", "8"]
    assert cli.main(["evolve", "mine.py", *small, "--out", "run"]) == 0
    assert (Path("run") / "champion.npz").exists()


def test_the_task_of_the_document_evolves() -> None:
    (block,) = re.findall(r"```python\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL)
    Path("my_task.py").write_text(block, encoding="utf-8")
    args = ["--set", "env.goal=2", "--strategy", "sep-cma-es", "--generations", "2"]
    for asked in ("my_task.py", "my_task.py:TASK", "my_task:TASK"):
        out = f"run-{asked.replace(':', '-')}"
        assert cli.main(["evolve", asked, *args, "--seed", "7", "--out", out]) == 0
