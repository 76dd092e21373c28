"""Tests of the script that prints where operations come from."""

import pytest
import scripted

from mjxwalk import cli

OPERATIONS = scripted.load("operations_by_source").OperationsBySource


@pytest.mark.parametrize(
    ("args", "complaint"),
    [(["h1", "--rows", "0"], "--rows must be at least 1, got 0"), (["nobody"], "nobody")],
)
def test_wrong_arguments_are_one_sentence(
    args: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run("operations_by_source.py", OPERATIONS, args) == 2
    assert complaint in capsys.readouterr().err


def test_a_rollout_is_told_by_the_files_of_this_package(capsys: pytest.CaptureFixture[str]) -> None:
    args = ["planar-lpd", "--by", "file", "--rows", "40"]
    assert cli.run("operations_by_source.py", OPERATIONS, args) == 0
    told = capsys.readouterr().out
    assert "planar-lpd, operations of a step" in told
    rows = [line.split() for line in told.splitlines()[2:]]
    assert {row[-1].split("/")[-1] for row in rows} >= {"dynamics.py", "contact.py", "smooth.py"}
    numbers = [int(row[0].replace(",", "")) for row in rows]
    assert sum(numbers[:-1]) == numbers[-1]
