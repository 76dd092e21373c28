"""Shows the weights of a run's champion, by network and input."""

import dataclasses
import os
import sys
from pathlib import Path
from typing import Any

from mjxwalk import cli, runs
from mjxwalk.cli.parsing import RunFolder
from mjxwalk.runs.result import npz


@dataclasses.dataclass(frozen=True, kw_only=True)
class Champion:
    """Show the champion's weights, or the fittest's so far of a run that is not finished.

    Attributes:
      run_folder: the run's folder.
      out: also write the weights to this npz file, by leaf name.
    """

    run_folder: RunFolder
    out: Path | None = None

    def run(self) -> int:
        """Prints the table and returns the exit code.

        Raises:
          RunError: there is no such run, or it has no generation yet.
        """
        run = runs.load(self.run_folder)
        arrays = run.champion or run.elite
        if not arrays:
            raise runs.RunError(f"{self.run_folder} has not saved a generation yet")
        print(_headline(run))
        for row in _table(run.experiment(), arrays):
            print("  ".join(row))
        if self.out is not None:
            _write(self.out, arrays)
        return 0


def _headline(run: runs.Run) -> str:
    if run.result is None:
        return f"fittest of generation {run.generation} of a run that is not finished"
    champion = run.result.champion
    return (
        f"champion of generation {champion.generation}: {champion.distance_m:.2f} m on average, "
        f"falls in {champion.fall_rate:.0%} of {champion.terrains} trials"
    )


def _table(experiment: Any, arrays: dict[str, Any]) -> list[list[str]]:
    rows = [
        [*labels, f"{value: .4f}"]
        for *labels, value in experiment.weight_table(runs.unflatten(experiment.template(), arrays))
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [[cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in rows]


def _write(path: Path, arrays: dict[str, Any]) -> None:
    try:
        path.write_bytes(npz(arrays))
    except OSError as error:
        raise runs.RunError(f"{path} could not be written: {error.strerror}") from None
    print(path)


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # a few numbers; leave the GPU to its owner
    sys.exit(cli.run("champion.py", Champion))
