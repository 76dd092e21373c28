"""Measures gaits: speed, step length, double stance and cost, beside a human's."""

import dataclasses
import sys
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from mjxwalk import cli, outputs, runs, walkers
from mjxwalk.cli.argument_types import Seed

Sources = tyro.conf.Positional[
    Annotated[tuple[str, ...], tyro.conf.arg(metavar="RUN|zoo:NAME ...")]
]
COLUMNS = {  # of the table, with the places that are shown
    "speed_m_s": 2,
    "step_length_m": 3,
    "double_stance": 3,
    "stride_time_s": 2,
    "swing_time_s": 2,
    "cost_of_transport": 3,
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class GaitTable:
    """Measure the gait of each source's best walker on new terrains.

    Figures are means and standard deviations over the trials without a fall.

    Attributes:
      sources: folders of runs, or walkers that ship with mjxwalk.
      trials: of each, every one on a terrain of its own.
      seed: of the terrains.
      duration: longest that a trial is watched, s; 0 for its whole length.
      csv: file to write the table to.
      engine: what runs the trials; auto takes the fastest on this machine.
    """

    sources: Sources
    trials: int = 100
    seed: Seed = 0
    duration: float = 0.0
    csv: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    engine: Literal["auto", "mjx", "lanes", "lanes-xla"] = "auto"

    def run(self) -> int:
        """Prints the table and returns the exit code.

        Raises:
          RunError: an argument is wrong, or there is no such source.
        """
        if not self.sources:
            raise runs.RunError("no runs were named")
        if self.csv is not None:
            outputs.check(self.csv, "--csv")
        if self.trials < 1:
            raise runs.RunError(f"--trials must be at least 1, got {self.trials}")
        if not self.duration >= 0.0:
            raise runs.RunError(f"--duration must not be negative, got {self.duration}")
        for source in self.sources:
            walkers.check(source)
        from mjxwalk import engines
        from mjxwalk.analysis import tables

        engines.prepare()
        table = tables.table_5({source: [self._measure(source)] for source in self.sources})
        print(_shown(table).to_string())
        if self.csv is not None:
            outputs.write_text(self.csv, table.to_csv())
            outputs.tell(self.csv)
        return 0

    def _measure(self, source: str) -> Any:
        from mjxwalk.analysis import gait, trials

        walker = walkers.best(source)
        walkers.check_walks(source, walker.experiment)
        try:
            recording = trials.record_trials(
                walker.experiment,
                walker.genotype,
                trials=self.trials,
                seed=self.seed,
                duration=self.duration or None,
                engine=self.engine,
            )
        except ValueError as error:
            raise runs.RunError(str(error)) from None
        measured = gait.measure_gait(recording, walker.experiment.as_tested().env)
        legs = len(walker.experiment.env.anatomy.legs)
        if legs != 2:
            print(f"{source}: has {legs} legs; strides are told of two alone", file=sys.stderr)
        if measured.falls == measured.trials:
            print(f"{source}: falls in all {measured.trials} trials", file=sys.stderr)
        return measured


def _shown(table: Any) -> Any:
    """Returns the table with each mean and its deviation in one cell."""
    shown = table[["trials", "falls"]].astype("string").fillna("")
    for name, places in COLUMNS.items():
        pairs = zip(table[name], table[f"{name}_sd"], strict=True)
        shown[name] = [_cell(mean, sd, places) for mean, sd in pairs]
    return shown


def _cell(mean: float, sd: float, places: int) -> str:
    if mean != mean:  # NaN
        return "-"
    return f"{mean:.{places}f}" if sd != sd else f"{mean:.{places}f} ± {sd:.{places}f}"


if __name__ == "__main__":
    sys.exit(cli.run("gait_table.py", GaitTable))
