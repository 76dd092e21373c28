"""Tests of what is shown in a terminal: names from anybody, and nothing that it obeys."""

import io
import os
import sys
from pathlib import Path

import pytest
import toy
from rich.console import Console

from mjxwalk import runs, terminal
from mjxwalk.cli import main
from mjxwalk.cli.progress_live import LiveProgress
from mjxwalk.experiments import run_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.runs import config

EVIL = "\x1b[2Jred\x07\x9b31m\u202etxt\r"


@pytest.fixture(autouse=True)
def toy_installed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    toy.install(monkeypatch)
    monkeypatch.chdir(tmp_path)


def check_harmless(text: str) -> None:
    assert not any(letter in text for letter in "\x1b\x07\x9b\u202e\r\udcff")


def test_what_a_terminal_obeys_is_shown_as_escapes_and_the_rest_as_it_is() -> None:
    assert terminal.visible("\x1b[2J") == "\\x1b[2J"
    assert terminal.visible("\u202e\udcff\x7f\x9b") == "\\u202e\\udcff\\x7f\\x9b"
    assert terminal.visible("Zürich – 3 ± 1 °\n\tä") == "Zürich – 3 ± 1 °\n\tä"
    assert terminal.one_line("a\nb\tc") == "a\\nb\\tc"
    check_harmless(terminal.visible(EVIL))


def test_all_that_a_command_prints_goes_through_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sys.stdout, sys.stderr
    with terminal.showing():
        print(EVIL)
        sys.stdout.writelines([EVIL, EVIL])
        print(EVIL, file=sys.stderr)
        assert sys.stdout.isatty() is before[0].isatty()
    assert (sys.stdout, sys.stderr) == before
    told = capsys.readouterr()
    assert told.out.count("red") == 3 and told.err.count("red") == 1
    check_harmless(told.out + told.err)


def test_list_shows_a_name_with_escape_sequences_in_one_row(
    capsys: pytest.CaptureFixture[str],
) -> None:
    name = os.fsdecode(b"\x1b[31mred\nfake  finished\xff")
    run_config.create(Path("runs", name), Config(experiment=toy.Toy()))
    run_config.create(Path("runs", "other"), Config(experiment=toy.Toy()))
    data = Path("runs", "other", config.FILE)
    data.write_text(data.read_text().replace('"seed": 0', '"\\u001b[31m": 0'))
    assert main(["list"]) == 0
    shown = capsys.readouterr().out
    check_harmless(shown)
    rows = [line for line in shown.splitlines() if "fake  finished" in line]
    assert len(rows) == 1 and "\\x1b[31mred\\nfake" in rows[0] and "stopped" in rows[0]


def test_a_complaint_shows_what_was_wrong_and_sends_nothing(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for args in (["report", EVIL], [EVIL], ["watch", EVIL], ["resume", os.fsdecode(b"\xff\x1b")]):
        assert main(args) == 2
        told = capsys.readouterr().err
        assert told.count("\n") == 1
        check_harmless(told)


def test_the_live_display_colours_and_the_texts_in_it_do_not() -> None:
    stream = io.StringIO()
    console = Console(file=stream, force_terminal=True, highlight=False)
    LiveProgress(console).say(f"[red]{EVIL}")
    check_harmless(stream.getvalue())
    assert "[red]" in stream.getvalue()


def test_a_setting_that_is_no_text_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    for text in ("strategy.name=\udcff", "strategy.sigma=" + "[" * 10**5, "env.friction=[[[]]]"):
        assert main(["evolve", "--set", text]) == 2
        told = capsys.readouterr().err
        assert told.startswith("mjxwalk: ") and told.count("\n") == 1
    assert not Path("runs").exists()


def test_a_run_with_a_name_that_is_no_text_evolves_and_is_started_from(
    capsys: pytest.CaptureFixture[str],
) -> None:
    name = os.fsdecode(b"\xffrun")
    assert main(["evolve", "--generations", "2", "--out", name]) == 0
    assert main(["resume", name]) == 0
    start = ["--set", "start=winner", "--from", name]
    assert main(["evolve", "--generations", "1", "--out", "b", *start]) == 0
    assert runs.load("b").config["origin"]["source"] == "\\udcffrun"
    assert main(["sweep", "toy", "--seeds", "1", *start]) == 2
    assert "is no UTF-8 text" in capsys.readouterr().err
