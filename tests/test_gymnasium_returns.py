"""Tests of the script that compares returns with those of Gymnasium's own environments."""

from pathlib import Path

import pytest
import scripted

from mjxwalk import cli

pytest.importorskip("gymnasium")
# A step is traced some times as fast.
pytestmark = pytest.mark.usefixtures("unchecked_types")


RETURNS = scripted.load("gymnasium_returns").GymnasiumReturns


@pytest.mark.slow
def test_gymnasium_returns_compares_random_policies_and_those_near_a_champion(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    args = ["evolve", "gymnasium/Hopper-v5", "--generations", "2", "--out", "hopper"]
    assert cli.main(args) == 0
    args = ["--tasks", "Hopper-v5", "--runs", "hopper", "--policies", "8", "--out", "table.md"]
    assert cli.run("gymnasium_returns.py", RETURNS, args) == 0
    table = Path("table.md").read_text()
    assert table in capsys.readouterr().out
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()[2:]]
    assert [row[:2] for row in rows] == [["Hopper-v5", "8 random"], ["Hopper-v5", "8 near hopper"]]
    for row in rows:
        assert float(row[2]) > 0.0 and float(row[3]) > 0.0 and float(row[8]) > 0.01
        assert row[6] == row[7] == "100%"  # all fall, and are alive until then


def test_what_cannot_be_compared_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run("gymnasium_returns.py", RETURNS, ["--tasks", "Hoper-v5"]) == 2
    assert "did you mean Hopper-v5" in capsys.readouterr().err
    not_of_gymnasium = ["--tasks", "Hopper-v5", "--runs", "zoo:reil"]
    assert cli.run("gymnasium_returns.py", RETURNS, not_of_gymnasium) == 2
    assert "zoo:reil is no run of one of Gymnasium's tasks" in capsys.readouterr().err
