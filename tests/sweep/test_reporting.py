"""Tests that what a sweep says to type reports on runs that can be averaged."""

import subprocess
from pathlib import Path

import pytest

from mjxwalk.cli.parsing import parse
from mjxwalk.cli.report import Report
from mjxwalk.cli.sweep import Sweep
from mjxwalk.cli.sweep_grid import make_plan
from mjxwalk.sweep import reporting
from mjxwalk.sweep.plan import Plan, Resources


def planned(*assignments: str, seeds: int = 3) -> Plan:
    return make_plan(Sweep(set=assignments), seeds, Resources())


def words(command: str, folder: Path) -> list[str]:
    """Returns what a shell makes of a command, in a folder."""
    printed = ["bash", "-c", f"printf '%s\\0' {command}"]
    said = subprocess.run(printed, cwd=folder, capture_output=True, text=True, check=True)
    return said.stdout.split("\0")[:-1]


@pytest.mark.parametrize("name", ["grid", "my grid", "-grid", "a*"])
@pytest.mark.parametrize(
    ("assignments", "groups"),
    [
        ((), 1),
        (("strategy.sigma=0.1",), 1),
        (("strategy.sigma=0.1,0.2",), 2),
        (("strategy.sigma=0.1,0.2", "env.max_time=1.0,10.0"), 4),
        (('name="a b","a-b"',), 2),  # whose folders cannot be told apart by a pattern
    ],
)
def test_each_command_takes_the_runs_of_one_choice_of_settings(
    name: str, assignments: tuple[str, ...], groups: int, tmp_path: Path
) -> None:
    made = planned(*assignments)
    for run in made.runs:
        (tmp_path / name / run.name).mkdir(parents=True)
    told = reporting.commands(Path(name), made)
    assert len(told) == groups
    seen: list[str] = []
    outs: set[object] = set()
    settings = {run.name: [a for a in run.args if "=" in a] for run in made.runs}
    for command in told:
        program, verb, *rest = words(command, tmp_path)
        assert (program, verb) == ("mjxwalk", "report")
        asked = parse("mjxwalk report", Report, rest)
        folders = [folder.name for folder in asked.run_folders]
        assert len(folders) == 3
        assert all(settings[folder] == settings[folders[0]] for folder in folders)
        seen += folders
        outs.add(asked.out)
    assert sorted(seen) == sorted(run.name for run in made.runs)
    assert len(outs) == groups


def test_of_many_choices_some_are_shown() -> None:
    values = ",".join(str(number) for number in range(1, 21))
    told = reporting.commands(Path("grid"), planned(f"generations={values}", seeds=2))
    assert len(told) == reporting.MOST + 1
    assert told[-1] == "... 12 more, one for each choice of settings"
