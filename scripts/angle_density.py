"""Draws how often each angle of a walker is where over a step."""

import dataclasses
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

from mjxwalk import cli, outputs, runs, walkers
from mjxwalk.analysis import style
from mjxwalk.cli.argument_types import Seed, Source
from mjxwalk.walker import Walker

AT_ONCE = 100  # trials that are recorded together; ours: less than 300 MB for a run of planar-lpd


@dataclasses.dataclass(frozen=True, kw_only=True)
class AngleDensity:
    """Draw the density of a walker's seven angles over a step, on new terrains.

    Trials with a fall do not count.

    Attributes:
      source: folder of a run, or a walker that ships with mjxwalk.
      out: the figure; its ending says which kind.
      trials: every one on a terrain of its own.
      seed: of the terrains.
      engine: what runs the trials; auto takes the fastest on this machine.
    """

    source: Source
    out: Path = Path("angles.png")
    trials: int = 100
    seed: Seed = 0
    engine: Literal["auto", "mjx", "lanes", "lanes-xla"] = "auto"

    @style.own()
    def run(self) -> int:
        """Writes the figure and returns the exit code.

        Raises:
          RunError: an argument is wrong, there is no such source, or nothing to draw.
        """
        if self.trials < 1:
            raise runs.RunError(f"--trials must be at least 1, got {self.trials}")
        walkers.check(self.source)
        outputs.check(self.out)
        from mjxwalk import engines
        from mjxwalk.analysis import angles, figures, roles

        engines.prepare()
        walker = walkers.best(self.source)
        walkers.check_walks(self.source, walker.experiment)
        if roles.roles_of(walker.experiment.env) is None:
            raise runs.RunError(f"{self.source} has no angles by role; see scripts/gait_table.py")
        env = walker.experiment.as_tested().env
        density = angles.angle_density(self._recordings(walker), env)
        if not density.steps:
            raise runs.RunError(f"{self.source} takes no whole step in a trial without a fall")
        outputs.write_figure(self.out, figures.angle_densities(density), dpi=150)
        outputs.tell(self.out)
        return 0

    def _recordings(self, walker: Walker) -> Iterator[Any]:
        from mjxwalk.analysis.trials import record_trials

        for place, first in enumerate(range(0, self.trials, AT_ONCE)):
            yield record_trials(
                walker.experiment,
                walker.genotype,
                trials=min(AT_ONCE, self.trials - first),
                seed=self.seed + place,
                engine=self.engine,
            )


if __name__ == "__main__":
    sys.exit(cli.run("angle_density.py", AngleDensity))
