"""A user's task as a text that tests change."""

from pathlib import Path

import pytest

from mjxwalk.experiments.own_task import trust

TEXT = (Path(__file__).parent / "toys" / "toy_task.py").read_text(encoding="utf-8")
SMALL = ["--generations", "2", "--population", "4"]


def changed(old: str, new: str) -> str:
    """Returns the text with a part of it changed."""
    assert old in TEXT, old
    return TEXT.replace(old, new, 1)


def line_of(text: str, part: str) -> int:
    """Returns the number of the first line with a part of a text."""
    return text[: text.index(part)].count("\n") + 1


def be(user: str, folder: Path, patch: pytest.MonkeyPatch) -> None:
    """Becomes a user who has never run anything in a new process, or one that was there before."""
    patch.setenv("XDG_DATA_HOME", str(folder / user))
    patch.setattr(trust, "_here", set())
