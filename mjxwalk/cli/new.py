"""The command `mjxwalk new`."""

import dataclasses
from pathlib import Path
from typing import Annotated, Literal

import tyro

from mjxwalk import outputs, shell
from mjxwalk.errors import RunError
from mjxwalk.experiments.own_task import examples


@dataclasses.dataclass(frozen=True, kw_only=True)
class New:
    """Write a Python file with a commented example, which evolves as it is.

    Attributes:
      kind: an environment with its fitness, a controller, or a strategy of your own.
      file: to write; one that is there stays as it is.
    """

    kind: tyro.conf.Positional[Literal["task", "controller", "strategy"]]
    file: tyro.conf.Positional[Annotated[Path, tyro.conf.arg(metavar="FILE.py")]]

    def run(self) -> int:
        """Writes the file, says what to do with it, and returns the exit code.

        Raises:
          RunError: the file is there already, or cannot be written.
        """
        if self.file.suffix != ".py":
            raise RunError(f"{self.file} must end in .py, as a file of Python does")
        outputs.create(self.file, examples.text(self.kind).encode())
        print(f"{self.file}: {examples.KINDS[self.kind]}")
        print(f"next: {shell.command('evolve', self.file)}")
        return 0
