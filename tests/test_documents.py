"""Tests that the commands in README and docs are commands."""

import re
import shlex
from pathlib import Path

import pytest

from mjxwalk.cli.commands import COMMANDS
from mjxwalk.cli.parsing import parse

ROOT = Path(__file__).parents[1]
DOCUMENTS = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
# What stands for what the reader has to fill in, and what to fill in here.
FILLED = {"...": "", "NUMBER": "1", "N": "1", "KIND": "npz"}


def commands(text: str) -> list[str]:
    """Returns the commands of mjxwalk in blocks of shell and between backticks."""
    blocks = re.findall(r"```sh\n(.*?)```", text, re.DOTALL)
    lines = [line for block in blocks for line in block.replace("\\\n", " ").splitlines()]
    inline = re.findall(r"`(mjxwalk [^`]*)`", re.sub(r"```.*?```", "", text, flags=re.DOTALL))
    found = [line.split("#")[0].strip() for line in lines] + inline
    return [" ".join(line.split()) for line in found if re.match(r"\S*mjxwalk \w", line)]


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_every_command_in_a_document_has_arguments_that_are_taken(document: Path) -> None:
    for line in commands(document.read_text(encoding="utf-8")):
        for sign, value in FILLED.items():
            line = re.sub(rf"(?<![A-Z]){re.escape(sign)}(?![A-Z])", value, line)
        _, name, *rest = shlex.split(line)
        if "--help" in rest or not rest and name != "list":
            assert name in COMMANDS, line
            continue
        parse(f"mjxwalk {name}", COMMANDS[name].load(), rest)


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_every_script_in_a_document_is_there(document: Path) -> None:
    for script in re.findall(
        r"\b((?:scripts|tests)/[\w/]+\.py)", document.read_text(encoding="utf-8")
    ):
        assert (ROOT / script).is_file(), script


def test_commands_are_found() -> None:
    assert len(commands((ROOT / "README.md").read_text(encoding="utf-8"))) > 15
