"""Makes the winner of a run's tournament one of the walkers that ship with mjxwalk."""

import dataclasses
import os
import sys
from pathlib import Path
from typing import Annotated

import tyro

from mjxwalk import cli
from mjxwalk.cli.argument_types import RunFolder


@dataclasses.dataclass(frozen=True, kw_only=True)
class ShipWinner:
    """Write the winner's weights and where they come from into the zoo; an old entry is replaced.

    Attributes:
      run_folder: of the run; `mjxwalk tournament` comes first.
      name: of the walker, which is then zoo:NAME.
      command: that made the run, if it is more than its settings tell.
      zoo: folder of the entries, if not that of this mjxwalk.
    """

    run_folder: RunFolder
    name: tyro.conf.Positional[Annotated[str, tyro.conf.arg(metavar="NAME")]]
    command: str | None = None
    zoo: Path | None = None

    def run(self) -> int:
        """Writes the entry, shows its figures, and returns the exit code.

        Raises:
          RunError: the run has no winner, or the files cannot be written.
        """
        from mjxwalk import shipping, zoo
        from mjxwalk.tournament import remarks

        folder = self.zoo or zoo.FOLDER
        shipped = shipping.ship(self.run_folder, self.name, folder, command=self.command)
        print(f"zoo:{self.name}: {remarks.figures(shipped.tournament)}")
        print(shipped.command)
        for ending in ("npz", "json"):
            print(folder / f"{self.name}.{ending}")
        return 0


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # a few numbers; leave the GPU to its owner
    sys.exit(cli.run("ship_winner.py", ShipWinner))
