"""Tries the best walker of a run on ground of other roughness, and at half its time step."""

import dataclasses
import os
import sys
from typing import Any

from mjxwalk import cli
from mjxwalk.cli.argument_types import RunFolder, Seed
from mjxwalk.errors import RunError

ROUGHNESS = (0.0, 0.001, 0.002, 0.004, 0.01)  # m


@dataclasses.dataclass(frozen=True, kw_only=True)
class OtherGrounds:
    """Print distance, speed and falls on each ground.

    Attributes:
      run_folder: of the run.
      trials: on each ground but the flat one, where all are the same.
      seed: of the terrains.
      set: another setting of the experiment for all of them, such as controller.posture=0.
    """

    run_folder: RunFolder
    trials: int = 100
    seed: Seed = 5
    set: str | None = None

    def run(self) -> int:
        """Prints a line for each ground and returns the exit code.

        Raises:
          RunError: the run has no walker, or there is no such setting.
        """
        if self.trials < 1:
            raise RunError(f"--trials must be at least 1, got {self.trials}")
        from mjxwalk import walkers
        from mjxwalk.settings import override

        walker = walkers.best(self.run_folder)
        walkers.check_walks(self.run_folder, walker.experiment)
        experiment = walker.experiment
        if self.set is not None:
            path, _, value = self.set.partition("=")
            experiment = override(experiment, path, value)
        for roughness in ROUGHNESS:
            rougher = override(experiment, "env.terrain.roughness", str(roughness))
            self._try(f"{1000 * roughness:g} mm", rougher, walker.genotype, roughness > 0)
            if roughness == 0.002:
                finer = rougher.finer(2)
                self._try("2 mm, half the time step", finer, walker.genotype, True)
        return 0

    def _try(self, label: str, experiment: Any, genotype: Any, varies: bool) -> None:
        import jax
        import numpy as np

        from mjxwalk import evaluation

        alone = jax.tree.map(lambda leaf: np.asarray(leaf)[None], genotype)
        num = self.trials if varies else 1
        terrains = experiment.sample_trials(jax.random.key(self.seed), num)
        tried = evaluation.make_evaluator(experiment, "auto").evaluate(alone, terrains)
        speed = tried.distance.sum() / tried.duration.sum()
        print(
            f"{label}: {tried.distance.mean():.1f} m in {tried.duration.mean():.1f} s "
            f"({speed:.2f} m/s), falls {int(tried.fell.sum())} of {num}",
            flush=True,
        )


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")
    sys.exit(cli.run("other_grounds.py", OtherGrounds))
