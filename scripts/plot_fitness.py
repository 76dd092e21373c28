"""Plots how a run's fitness and distance went, generation by generation."""

import dataclasses
import sys
from pathlib import Path
from typing import Any

from mjxwalk import cli, outputs, runs, terminal
from mjxwalk.analysis import style
from mjxwalk.cli.argument_types import RunFolder


@dataclasses.dataclass(frozen=True, kw_only=True)
class PlotFitness:
    """Plot a run's fitness, distance and falls against the generation.

    Attributes:
      run_folder: the run's folder.
      out: the figure; its ending says which kind.
    """

    run_folder: RunFolder
    out: Path = Path("fitness.png")

    @style.own()
    def run(self) -> int:
        """Writes the figure and returns the exit code.

        Raises:
          RunError: there is no such run, or nothing to plot.
        """
        outputs.check(self.out)
        metrics = runs.load(self.run_folder).metrics
        if not len(metrics["generation"]):
            raise runs.RunError(f"{self.run_folder} has not finished a generation yet")
        plot(metrics, title=terminal.one_line(self.run_folder.name), out=self.out)
        outputs.tell(self.out)
        return 0


def plot(metrics: dict[str, Any], *, title: str, out: Path) -> None:
    """Draws the figures of a run over its generations into a file."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 7), layout="constrained")
    axes: Any = figure.subplots(3, 1, sharex=True)
    for axis, quantity in zip(axes, ("fitness", "distance_m"), strict=False):
        for which in ("best", "mean", "median"):
            axis.plot(metrics["generation"], metrics[f"{which}_{quantity}"], label=which)
    axes[0].set_ylabel("fitness")
    axes[1].set_ylabel("distance (m)")
    axes[0].legend()
    axes[0].set_title(title)
    axes[2].plot(metrics["generation"], metrics["fall_share"])
    axes[2].set_ylabel("share of falls")
    axes[2].set_ylim(-0.02, 1.02)
    axes[2].set_xlabel("generation")
    outputs.write_figure(out, figure)


if __name__ == "__main__":
    sys.exit(cli.run("plot_fitness.py", PlotFitness))
