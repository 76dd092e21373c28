"""Draws a walker as it walks: stick figures on their terrain, side by side in time."""

import dataclasses
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

from mjxwalk import cli, outputs, runs, walkers
from mjxwalk.analysis import style
from mjxwalk.cli.argument_types import Seed, Source
from mjxwalk.walker import Walker

SHORTEST = 0.01  # s between figures; closer ones cannot be told apart


@dataclasses.dataclass(frozen=True, kw_only=True)
class StickFigures:
    """Draw the tournament's winner, else the champion, else the fittest so far.

    Attributes:
      source: folder of a run, or a walker that ships with mjxwalk.
      out: the figure; its ending says which kind.
      start: of the first figure, s.
      duration: from there to the last one, s.
      interval: from one figure to the next, s.
      terrain_seed: of the random terrain.
    """

    source: Source
    out: Path = Path("walker.png")
    start: float = 2.0
    duration: float = 4.0
    interval: float = 0.2
    terrain_seed: Seed = 0

    @style.own()
    def run(self) -> int:
        """Writes the figure and returns the exit code.

        Raises:
          RunError: an argument is wrong, there is no such source, or nothing to draw.
        """
        if not (self.interval >= SHORTEST and self.start >= 0.0 and self.duration >= 0.0):
            raise runs.RunError(
                f"--interval must be at least {SHORTEST}, --start and --duration not negative, got "
                f"{self.interval}, {self.start} and {self.duration}"
            )
        walkers.check(self.source)
        outputs.check(self.out)
        figure = self._draw(walkers.best(self.source))
        outputs.write_figure(self.out, figure, facecolor="white")
        outputs.tell(self.out)
        return 0

    def _draw(self, walker: Walker) -> Any:
        import jax

        from mjxwalk import engines, replay
        from mjxwalk.analysis import sticks

        engines.prepare()
        walkers.check_walks(self.source, walker.experiment)
        experiment = walker.experiment.as_tested()
        env, key = experiment.env, jax.random.key(self.terrain_seed)
        interval = min(self.interval, env.max_time)
        trials = experiment.sample_trials(key, 1)
        recording = replay.record(
            env,
            experiment.controller,
            jax.tree.map(lambda leaf: np.asarray(leaf)[None], walker.genotype),
            trials.given(np.zeros(1, np.int32)),
            duration=max(min(self.start + self.duration, env.max_time), interval),
            frames_per_second=1.0 / interval,
        )
        walking = (recording.time[:, 0] >= self.start) & ~recording.done[:, 0]
        if not walking.any():
            raise runs.RunError(f"the walker's trial is over before {self.start} s")
        ground = trials.given(0).ground
        return sticks.draw(sticks.find(env, recording.states.qpos[walking, 0], ground))


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # one walker; leave the GPU to its owner
    sys.exit(cli.run("stick_figures.py", StickFigures))
