"""Tells how spatial walkers do on new ground: falls, cost, and what their gait may hide."""

import dataclasses
import os
import sys
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro

from mjxwalk import cli, outputs, runs, walkers
from mjxwalk.cli.argument_types import OptionalFloat, Seed

Sources = tyro.conf.Positional[tuple[Annotated[str, tyro.conf.arg(metavar="RUN|zoo:NAME")], ...]]
RECORDED = 10  # trials of each walker that are looked at frame by frame


@dataclasses.dataclass(frozen=True, kw_only=True)
class SpatialTable:
    """Try the best walker of each run on new ground, at its own time step and at half of it.

    Attributes:
      sources: folders of runs, or walkers that ship with mjxwalk.
      terrains: new ones that each is tried on.
      roughness: step of the random terrain, m.
      seed: of the terrains.
      csv: file to write the table to as well.
    """

    sources: Sources = ()
    terrains: int = 1000
    roughness: OptionalFloat = None
    seed: Seed = 0
    csv: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None

    def run(self) -> int:
        """Shows the table and returns the exit code.

        Raises:
          RunError: an argument is wrong, or a walker is not spatial.
        """
        if not self.sources:
            raise runs.RunError("no runs were named")
        if self.csv is not None:
            outputs.check(self.csv, "--csv")
        if self.terrains < 1:
            raise runs.RunError(f"--terrains must be at least 1, got {self.terrains}")
        for source in self.sources:
            walkers.check(source)
        import pandas as pd

        from mjxwalk import engines

        engines.prepare()
        table = pd.DataFrame([self._row(source) for source in self.sources])
        print(table.to_string(index=False, float_format=lambda value: f"{value:.3f}"))
        if self.csv is not None:
            outputs.write_text(self.csv, table.to_csv(index=False))
            outputs.tell(self.csv)
        return 0

    def _row(self, source: str) -> dict[str, Any]:
        from mjxwalk.analysis import faults, trials
        from mjxwalk.settings import override

        walker = walkers.best(source)
        walkers.check_walks(source, walker.experiment)
        if walker.experiment.env.anatomy.root.is_planar:
            raise runs.RunError(f"{source} walks in the plane, and this is for walkers in space")
        experiment = walker.experiment.as_tested()
        if self.roughness is not None:
            experiment = override(experiment, "env.terrain.roughness", str(self.roughness))
        recording = trials.record_trials(
            experiment, walker.genotype, trials=RECORDED, seed=self.seed
        )
        measured = faults.measure_faults(recording, experiment.env)
        half = override(experiment, "env.timestep", str(experiment.env.timestep / 2))
        return {
            "walker": Path(source).name,
            **self._try(experiment, walker.genotype),
            "falls, half step": self._try(half, walker.genotype)["falls"],
            **{name: float(measured[name].abs().mean()) for name in faults.FAULTS},
        }

    def _try(self, experiment: Any, genotype: Any) -> dict[str, float]:
        from mjxwalk.analysis.trials import try_alone
        from mjxwalk.outcomes import cost_of_transport, speed

        tried = try_alone(experiment, genotype, terrains=self.terrains, seed=self.seed)
        return {
            "distance (m)": float(tried.distance.mean()),
            "falls": float(tried.fell.mean()),
            "speed (m/s)": speed(tried.distance, tried.duration) or np.nan,
            "cost": cost_of_transport(tried.work, tried.distance, experiment.weight) or np.nan,
        }


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # a few walkers; leave the GPU to its owner
    sys.exit(cli.run("spatial_table.py", SpatialTable))
