"""The commands by name. Naming them is quick: a command's module is imported when it is asked for.

A command is one frozen dataclass of arguments with `run`. Its module must not import JAX; what
needs JAX is imported inside `run`, after the arguments are known to be right.
"""

import importlib
from collections.abc import Mapping
from typing import NamedTuple, Protocol, runtime_checkable


@runtime_checkable
class Command(Protocol):
    """A dataclass of a command's arguments."""

    def run(self) -> int:
        """Does what was asked for and returns the exit code."""
        ...


class Entry(NamedTuple):
    """Where a command is, and what it does in a line."""

    module: str
    attribute: str
    summary: str

    def load(self) -> type[Command]:
        """Returns the command's dataclass."""
        return getattr(importlib.import_module(self.module), self.attribute)


COMMANDS: Mapping[str, Entry] = {
    "evolve": Entry("mjxwalk.cli.evolve", "Evolve", "evolve walkers, in a folder of their own"),
    "resume": Entry("mjxwalk.cli.evolve", "Resume", "go on with a run that did not end"),
    "sweep": Entry("mjxwalk.cli.sweep", "Sweep", "evolve a grid of seeds and settings"),
    "new": Entry("mjxwalk.cli.new", "New", "write an example of a task of your own in Python"),
    "tournament": Entry(
        "mjxwalk.cli.tournament", "HoldTournament", "find the best walker of a run and try it"
    ),
    "watch": Entry("mjxwalk.cli.watch", "Watch", "write a page on which walkers walk, in 3D"),
    "verify": Entry(
        "mjxwalk.cli.verify", "Verify", "walk the best walker again in C MuJoCo, and compare"
    ),
    "export": Entry(
        "mjxwalk.cli.export", "Export", "write controller, body or gait for other programs"
    ),
    "report": Entry("mjxwalk.cli.report", "Report", "write one page on runs, beside the paper"),
    "list": Entry("mjxwalk.cli.list", "List", "show experiments, the zoo, and runs"),
    "doctor": Entry("mjxwalk.cli.doctor", "Doctor", "show versions, devices, and what is missing"),
    "bench": Entry("mjxwalk.cli.bench", "Bench", "measure how fast the engines are here"),
}


def overview(program: str) -> str:
    """Returns the help on all commands."""
    width = max(map(len, COMMANDS))
    lines = [f"  {name.ljust(width)}  {entry.summary}" for name, entry in COMMANDS.items()]
    return "\n".join(
        [
            f"usage: {program} COMMAND ...",
            "",
            "Evolve walking controllers for simulated bipeds.",
            "",
            *lines,
            "",
            f"{program} COMMAND --help tells more; {program} --version tells the version.",
        ]
    )
