"""Draws a run's champion as it walks: stick figures on their terrain, side by side in time."""

import dataclasses
import importlib.util
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

from mjxwalk import cli, runs
from mjxwalk.cli.parsing import RunFolder

NEAR, FAR, GROUND = "#1f4e8c", "#9db7d6", "#b9b3a6"  # left leg, right leg, terrain


@dataclasses.dataclass(frozen=True, kw_only=True)
class StickFigures:
    """Draw the champion, or the fittest so far of a run that is not finished.

    Attributes:
      run_folder: the run's folder.
      out: the figure; its ending says which kind.
      start: of the first figure, s.
      duration: from there to the last one, s.
      interval: from one figure to the next, s.
      terrain_seed: of the random terrain.
    """

    run_folder: RunFolder
    out: Path = Path("walker.png")
    start: float = 2.0
    duration: float = 4.0
    interval: float = 0.2
    terrain_seed: int = 0

    def run(self) -> int:
        """Writes the figure and returns the exit code.

        Raises:
          RunError: there is no such run, nothing to draw, or no matplotlib.
        """
        if importlib.util.find_spec("matplotlib") is None:
            raise runs.RunError("matplotlib is missing; `mjxwalk doctor` says how to add it")
        run = runs.load(self.run_folder)
        arrays = run.champion or run.elite
        if not arrays:
            raise runs.RunError(f"{self.run_folder} has not saved a generation yet")
        experiment = run.experiment()
        genotype = runs.unflatten(experiment.template(), arrays)
        try:
            self._draw(experiment, genotype)
        except (OSError, ValueError) as error:
            raise runs.RunError(f"{self.out} could not be written: {error}") from None
        print(self.out)
        return 0

    def _draw(self, experiment: Any, genotype: Any) -> None:
        import jax
        from matplotlib.figure import Figure

        from mjxwalk import engines, replay
        from mjxwalk.envs import Terrain

        engines.prepare()
        env = experiment.env
        heights = experiment.sample_terrains(jax.random.key(self.terrain_seed), 1, 0)
        terrain: Any = Terrain(heights, np.zeros(1, np.int32))  # type: ignore[arg-type]
        recording = replay.record(
            env,
            experiment.controller,
            jax.tree.map(lambda leaf: np.asarray(leaf)[None], genotype),
            terrain,
            duration=self.start + self.duration,
            frames_per_second=1.0 / self.interval,
        )
        walking = (recording.time[:, 0] >= self.start) & ~recording.done[:, 0]
        figures = replay.skeleton(env, recording.states.qpos[:, 0])[walking]
        if not len(figures):
            raise runs.RunError(f"the walker's trial is over before {self.start} s")
        left, right = figures[..., 0].min() - 0.2, figures[..., 0].max() + 0.2
        low, high = figures[..., 1].min() - 0.15, figures[..., 1].max() + 0.1
        canvas = Figure(figsize=(12, 12 * (high - low) / (right - left)), dpi=120)
        axis = canvas.add_axes((0.0, 0.0, 1.0, 1.0))
        ground = env.terrain
        nodes = ground.start + ground.spacing * np.arange(ground.num_nodes)
        axis.fill_between(nodes, heights[0], low, color=GROUND, linewidth=0)
        for figure in figures:
            for leg, colour in ((1, FAR), (0, NEAR)):
                axis.plot(*figure[leg].T, color=colour, linewidth=2, solid_capstyle="round")
        axis.set(xlim=(left, right), ylim=(low, high), aspect="equal")
        axis.axis("off")
        canvas.savefig(self.out, facecolor="white")


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # one walker; leave the GPU to its owner
    sys.exit(cli.run("stick_figures.py", StickFigures))
