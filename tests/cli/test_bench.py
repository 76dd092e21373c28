"""Tests of the command: what it refuses, and what it writes."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from bench.given import RESULTS

from mjxwalk.bench import measuring
from mjxwalk.bench.measuring import FULL, QUICK, Sizes
from mjxwalk.bench.names import BODIES, USUAL
from mjxwalk.bench.results import Results
from mjxwalk.cli import main


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Sizes]:
    """Returns the sizes that were measured; the results are made up."""
    measured: list[Sizes] = []

    def measure(names: Any, sizes: Sizes, say: Any) -> Results:
        assert names == USUAL
        measured.append(sizes)
        return RESULTS

    monkeypatch.setattr(measuring, "measure", measure)
    return measured


@pytest.mark.parametrize(
    ("path", "why"),
    [
        ("nowhere/b.json", "is in no folder that is there; make nowhere first"),
        (".", "is a folder; name a file in it"),
    ],
)
def test_a_file_that_cannot_be_written_is_refused_before_measuring(
    path: str,
    why: str,
    asked: list[Sizes],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["bench", "--json", path]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == f"mjxwalk: --json {path} {why}\n"
    assert not asked
    assert not list(tmp_path.iterdir())


def test_an_old_file_is_kept_until_there_are_new_numbers(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = tmp_path / "bench.json"
    file.write_text("old")

    def stopped(names: Any, sizes: Sizes, say: Any) -> Results:
        raise KeyboardInterrupt

    monkeypatch.setattr(measuring, "measure", stopped)
    assert main(["bench", "--json", str(file)]) == 130
    assert file.read_text() == "old"


def test_json_holds_what_is_shown(
    asked: list[Sizes], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "bench.json"
    assert main(["bench", "--quick", "--json", str(file)]) == 0
    assert asked == [QUICK]
    data = json.loads(file.read_text())
    assert data["bodies"]["planar7-points"]["ratios"]["mjx"] == 250.0
    shown = capsys.readouterr().out
    assert "200 k  250" in shown
    assert re.search(rf"took \d+ s, wrote {re.escape(str(file))}\n$", shown)


def test_quick_measures_less_of_everything(asked: list[Sizes]) -> None:
    assert main(["bench"]) == 0
    assert asked == [FULL]
    assert QUICK.population == FULL.population
    assert QUICK.populations[-1] < FULL.populations[-1]
    assert QUICK.seconds * QUICK.repeats < FULL.seconds * FULL.repeats


def test_a_body_that_is_not_there_is_refused_before_measuring(
    asked: list[Sizes], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", "--bodies", "h1", "walker2"]) == 2
    assert "--bodies has no walker2; did you mean walker2d" in capsys.readouterr().err
    assert not asked


def test_the_bodies_are_listed(asked: list[Sizes], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--bodies", "list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(BODIES)
    assert not asked
