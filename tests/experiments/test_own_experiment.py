"""Tests of the experiment in docs/experiments.md, in processes of its own program."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

DOCUMENT = Path(__file__).parents[2] / "docs" / "experiments.md"


def own(folder: Path, *args: str) -> str:
    """Returns what a command of the program in the document says."""
    done = subprocess.run(
        [sys.executable, "mine.py", *args],
        cwd=folder,
        capture_output=True,
        encoding="utf-8",
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_the_experiment_of_the_document_evolves_and_every_command_knows_it(tmp_path: Path) -> None:
    (block,) = re.findall(r"```python\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "mine.py").write_text(block, encoding="utf-8")
    small = ["--generations", "2", "--population", "8", "--set", "env.price=0.01"]
    own(tmp_path, "evolve", "steady", "--out", "run", *small)
    for name in ("result.json", "champion.npz"):
        (tmp_path / "run" / name).unlink()
    assert "evolved steady" in own(tmp_path, "resume", "run")
    assert "the winner of run" in own(tmp_path, "tournament", "run", "--terrains", "20")
    own(tmp_path, "watch", "run", "--out", "page.html")
    own(tmp_path, "report", "run", "--trials", "4")
    assert "price=0.01" in (tmp_path / "run/report/report.html").read_text(encoding="utf-8")
    assert "steady" in own(tmp_path, "list", "--runs", ".")
