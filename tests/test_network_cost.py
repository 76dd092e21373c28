"""Tests of the script that measures what networks cost."""

import pytest
import scripted

from mjxwalk import cli

COST = scripted.load("network_cost").NetworkCost


@pytest.mark.parametrize(
    ("args", "complaint"),
    [
        (["--repeats", "0"], "--repeats must be at least 1, got 0"),
        (["--population", "0"], "--population must be at least 1, got 0"),
        (["--hidden", "8", "0x8"], "from 1 to 4,096 a layer, got [0, 8]"),
        (["--hidden", "many"], "controller.hidden must be a list such as [1, 2], got '[many]'"),
        (["--body", "nobody"], "nobody"),
    ],
)
def test_wrong_arguments_are_one_sentence(
    args: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run("network_cost.py", COST, args) == 2
    told = capsys.readouterr().err
    assert complaint in told and told.count("\n") == 1


@pytest.mark.slow
def test_a_larger_network_has_more_weights_and_takes_longer_to_step(
    capsys: pytest.CaptureFixture[str],
) -> None:
    args = ["--hidden", "32x32", "--population", "32", "--repeats", "3", "--seconds", "0.2"]
    assert cli.run("network_cost.py", COST, args) == 0
    linear, network = (
        [cell.strip() for cell in line.split("|")[1:-1]]
        for line in capsys.readouterr().out.splitlines()[-2:]
    )
    assert (linear[0], network[0]) == ("linear", "32x32")
    assert int(linear[1]) < 100 < 1000 < int(network[1].replace(",", ""))
    assert linear[-1] == "1.00" and float(network[-1]) > 1.0
