"""Prints which lines of Python the operations of a step come from, in the kernels of lanes."""

import dataclasses
import sys
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from mjxwalk import cli, experiments, terminal
from mjxwalk.cli.argument_types import ContactLaw, OptionalName
from mjxwalk.cli.evolve_arguments import EvolveArguments
from mjxwalk.errors import RunError


@dataclasses.dataclass(frozen=True, kw_only=True)
class OperationsBySource:
    """Print where the operations of a step of rollouts come from, most of them first.

    A step is one of control; in Gymnasium's tasks several steps of the physics are within it.

    Attributes:
      subjects: experiments, bodies that ship or files of bodies.
      by: what operations are summed by; a line of a file, a function or a file.
      rows: of each table.
      controller: as `mjxwalk evolve` takes it.
      contact: as `mjxwalk evolve` takes it.
      set: as `mjxwalk evolve` takes it.
    """

    subjects: tyro.conf.Positional[Annotated[list[str], tyro.conf.arg(metavar="NAME|FILE")]]
    by: Literal["line", "function", "file"] = "function"
    rows: int = 25
    controller: OptionalName = None
    contact: ContactLaw = None
    set: Annotated[
        tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar="PATH=VALUE")
    ] = ()

    def run(self) -> int:
        """Prints the tables and returns the exit code.

        Raises:
          RunError: an argument is wrong.
        """
        if self.rows < 1:
            raise RunError(f"--rows must be at least 1, got {self.rows}")
        from mjxwalk import engines

        engines.prepare()
        for subject in self.subjects:
            self._show(subject, self._experiment(subject))
        return 0

    def _experiment(self, subject: str) -> Any:
        from mjxwalk.cli import choosing

        is_named = subject in experiments.names()
        asked = EvolveArguments(
            experiment=subject if is_named else experiments.ANY_BODY,
            body=None if is_named else Path(subject),
            controller=self.controller,
            contact=self.contact,
            set=self.set,
        )
        return choosing.choose_run(asked).settings.experiment

    def _show(self, subject: str, experiment: Any) -> None:
        import jax

        from mjxwalk.engines.lanes import by_source

        given = experiment.sample_trials(jax.random.key(0), 1).given(0)
        found = by_source.sources(experiment.rollout, experiment.template(), given)
        terminal.say(f"{subject}, operations of a step")
        terminal.say(by_source.text(found.of_step, self.by, self.rows))


if __name__ == "__main__":
    sys.exit(cli.run("operations_by_source.py", OperationsBySource))
