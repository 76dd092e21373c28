"""Tests that what the program says to type does what it says."""

import os
import shlex
import subprocess
from pathlib import Path

import pytest
import toy

from mjxwalk import shell
from mjxwalk.cli import main

NAMES = (
    "plain",
    "my run",
    "two  spaces",
    "it's",
    'a "b"',
    "$HOME",
    "`id`",
    "a\\b",
    "-run",
    "--out",
    "~",
    "a*",
    "a;b",
    "line\nbreak",
    "tab\t1",
    "\x1b[31mred",
    "caf\u00e9",
    "no text \udcff",
    "'\n1",
)


@pytest.mark.parametrize("name", NAMES)
def test_a_shell_reads_a_quoted_path_as_it_was(name: str) -> None:
    said = subprocess.run(
        ["bash", "-c", f"printf %s {shell.quoted(Path(name))}"], capture_output=True, check=True
    )
    assert said.stdout.removeprefix(b"./") == os.fsencode(name)
    assert b"\n" not in os.fsencode(shell.quoted(name))
    assert not shell.quoted(Path(name)).startswith("-")


@pytest.mark.parametrize("name", NAMES)
def test_what_a_run_says_to_type_names_the_run(
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    toy.install(monkeypatch)
    again = ["evolve", "--generations", "2", f"--out={name}"]
    assert main(again) == 0
    out = capfd.readouterr().out
    assert main(again) == 2
    error = capfd.readouterr().err
    told = [*out[out.index("next: ") + 6 :].splitlines(), error.split("`")[1::2][0]]
    if "`" in name:  # which stands between the backticks of the sentence
        told.pop()
    for command in told:
        program, verb, path = read_by_bash(command)
        assert (program, verb) == (b"mjxwalk", verb)
        assert path.removeprefix(b"./") == os.fsencode(name)


def read_by_bash(command: str) -> list[bytes]:
    """Returns the words that a shell makes of a command."""
    said = subprocess.run(["bash", "-c", f"printf '%s\\0' {command}"], capture_output=True)
    return said.stdout.split(b"\0")[:-1]


def test_a_word_that_needs_no_quotes_has_none() -> None:
    assert shell.command("resume", Path("runs/a-1")) == "mjxwalk resume runs/a-1"
    assert shlex.split(shell.command("watch", "zoo:planar-lpd"))[-1] == "zoo:planar-lpd"
