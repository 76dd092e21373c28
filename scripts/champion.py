"""Shows the weights of a run's best walker, by network and input."""

import dataclasses
import os
import sys
from pathlib import Path
from typing import Any

from mjxwalk import cli, outputs, walkers
from mjxwalk.cli.argument_types import Source
from mjxwalk.runs.npz import npz
from mjxwalk.walker import Walker


@dataclasses.dataclass(frozen=True, kw_only=True)
class Champion:
    """Show the weights of the tournament's winner, else the champion's, else the fittest's so far.

    Attributes:
      source: folder of a run, or a walker that ships with mjxwalk.
      out: also write the weights to this npz file, by leaf name.
    """

    source: Source
    out: Path | None = None

    def run(self) -> int:
        """Prints the table and returns the exit code.

        Raises:
          RunError: there is no such source, or it has no walker yet.
        """
        if self.out is not None:
            outputs.check(self.out)
        walker = walkers.best(self.source)
        print(f"{walker.rank} of generation {walker.generation}, from {walker.name}")
        for row in _table(walker):
            print("  ".join(row))
        if self.out is not None:
            _write(self.out, walker.genotype)
        return 0


def _table(walker: Walker) -> list[list[str]]:
    rows = [
        [*labels, f"{value: .4f}"]
        for *labels, value in walker.experiment.weight_table(walker.genotype)
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [[cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in rows]


def _write(path: Path, genotype: Any) -> None:
    from mjxwalk.runs.trees import flatten

    outputs.write(path, npz(flatten(genotype)))
    outputs.tell(path)


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # a few numbers; leave the GPU to its owner
    sys.exit(cli.run("champion.py", Champion))
