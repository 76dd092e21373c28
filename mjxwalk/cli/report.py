"""The command `mjxwalk report`."""

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import tyro

from mjxwalk import budget, shell, terminal
from mjxwalk.cli.argument_types import EngineName, Seed
from mjxwalk.errors import RunError

RunFolders = tyro.conf.Positional[
    Annotated[tuple[Path, ...], tyro.conf.arg(metavar="RUN [RUN ...]")]
]
FOLDER = "report"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Report:
    """Write one page on runs or studies, beside published numbers where there are some.

    The page is report.html, which needs no network; beside it is a CSV file for each table. Several
    runs of one experiment are averaged.

    Attributes:
      run_folders: of runs or studies, finished or not.
      out: folder of the page; RUN/report for one run, ./report for several.
      trials: of each winner that are recorded for gait and angles; 0 for none.
      seed: of their terrains.
      engine: what runs the trials; auto takes the fastest on this machine.
      trust: execute the code of the runs, which somebody else wrote.
    """

    run_folders: RunFolders
    out: Annotated[Path | None, tyro.conf.arg(metavar="FOLDER")] = None
    trials: int = 100
    seed: Seed = 0
    engine: EngineName = "auto"
    trust: bool = False

    def run(self) -> int:
        """Writes the page and returns the exit code.

        Raises:
          RunError: an argument is wrong, or there is nothing to report on.
        """
        if self.trials < 0:
            raise RunError(f"--trials must not be negative, got {self.trials}")
        budget.check_asked("--trials", self.trials)
        _check(self.run_folders, trust=self.trust)
        from mjxwalk import engines
        from mjxwalk.report import building, page

        folder, inside = self._place()
        page.prepare(folder, inside)
        engines.prepare()
        try:
            built = building.build(
                self.run_folders,
                num_trials=self.trials,
                seed=self.seed,
                engine=self.engine,
                say=terminal.say,
            )
        except ValueError as error:
            raise RunError(str(error)) from None
        for path in page.write(folder, built, inside):
            print(path)
        return 0

    def _place(self) -> tuple[Path, str]:
        """Returns the folder that the user named, and the page's folder in it, "" for itself."""
        if self.out is None and len(self.run_folders) == 1:
            return self.run_folders[0], FOLDER
        return self.out or Path(FOLDER), ""


def _check(paths: Sequence[Path], *, trust: bool) -> None:
    """Returns if there is something to report on in each folder; quick, as JAX is not imported.

    Raises:
      RunError: there is none.
    """
    if not paths:
        raise RunError("name at least one run to report on; `mjxwalk list` shows those in ./runs")
    from mjxwalk import walkers
    from mjxwalk.runs import config, metrics, study

    known: dict[Path, Path] = {}
    for path in paths:
        if walkers.in_zoo(path):
            raise RunError(f"{path} is one walker without a run; a report needs a run's folder")
        other = known.setdefault(path.resolve(), path)
        if other is not path:
            raise RunError(f"{path} is named twice, and would count twice; name each run once")
        if study.is_study(path):
            places = [file.parent for file in path.glob(f"*/{config.FILE}")]
        else:
            walkers.check(path, trust=trust)
            places = [path]
        if not any(metrics.read(place) for place in places):
            raise RunError(
                f"{path} has no generation yet; evolve it: {shell.command('resume', path)}"
            )
