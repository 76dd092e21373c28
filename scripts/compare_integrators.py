"""Tries a run's best walker under other time steps and integrators: does its gait hang on them?"""

import dataclasses
import sys
from typing import Any

from mjxwalk import cli, walkers
from mjxwalk.cli.argument_types import Seed, Source
from mjxwalk.errors import RunError

VARIANTS = (
    ("implicit", 0.001),
    ("implicit", 0.0005),
    ("implicit", 0.00025),
    ("explicit", 0.0002),  # the paper's
    ("explicit", 0.0001),
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class CompareIntegrators:
    """Compare the best walker's trials under the implicit and the explicit integrator.

    Attributes:
      source: folder of a run, or a walker that ships with mjxwalk.
      terrains: new terrains, the same for every integrator.
      seed: of the terrains.
    """

    source: Source
    terrains: int = 1000
    seed: Seed = 0

    def run(self) -> int:
        """Prints the table and returns the exit code.

        Raises:
          RunError: there is no such source, or it has no walker yet.
        """
        if self.terrains < 1:
            raise RunError(f"--terrains must be at least 1, got {self.terrains}")
        walker = walkers.best(self.source)
        walkers.check_walks(self.source, walker.experiment)
        experiment = walker.experiment.as_tested()
        print("| integrator | step (ms) | distance (m) | falls | speed (m/s) | cost of transport |")
        print("| --- | --- | --- | --- | --- | --- |")
        for integrator, timestep in VARIANTS:
            env = dataclasses.replace(experiment.env, integrator=integrator, timestep=timestep)
            figures = self._try(dataclasses.replace(experiment, env=env), walker.genotype)
            print(f"| {integrator} | {1000 * timestep:g} | {figures} |", flush=True)
        return 0

    def _try(self, experiment: Any, genotype: Any) -> str:
        from mjxwalk import engines
        from mjxwalk.analysis.trials import try_alone
        from mjxwalk.outcomes import cost_of_transport, speed

        engines.prepare()
        trials = try_alone(experiment, genotype, terrains=self.terrains, seed=self.seed)
        return (
            f"{trials.distance.mean():.2f} | {trials.fell.mean():.1%} | "
            f"{_cell(speed(trials.distance, trials.duration))} | "
            f"{_cell(cost_of_transport(trials.work, trials.distance, experiment.weight))}"
        )


def _cell(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"


if __name__ == "__main__":
    sys.exit(cli.run("compare_integrators.py", CompareIntegrators))
