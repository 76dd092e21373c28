"""Compares strategies on functions and on walkers: how far each gets for the same effort."""

import dataclasses
import functools
import json
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

from mjxwalk import cli, experiments, outputs
from mjxwalk.analysis import style
from mjxwalk.errors import RunError, near

STRATEGIES = ("self-adaptive-ga", "deep-ga", "cma-es", "sep-cma-es", "snes", "pgpe", "openai-es")
LATEST = 10  # ours: generations whose median best fitness is what walkers have reached


@dataclasses.dataclass(frozen=True, kw_only=True)
class CompareStrategies:
    """Compare strategies on functions and on walkers. What is done is kept, and not done again.

    Attributes:
      out: folder of the curves, the table and the figure.
      strategies: by name.
      weights: numbers of weights of the functions.
      evaluations: of each function.
      experiments: whose walkers evolve.
      million_steps: of the physics, in each evolution.
      population: of the walkers; 0 for the experiment's.
      seeds: of each strategy on each function and experiment.
      engine: that runs the walkers.
    """

    out: Path = Path("strategies")
    strategies: tuple[str, ...] = STRATEGIES
    weights: tuple[int, ...] = (10, 40)
    evaluations: int = 20_000
    experiments: tuple[str, ...] = ("planar-lpd", "planar-fil")
    million_steps: float = 200.0
    population: int = 0
    seeds: int = 10
    engine: str = "auto"

    @style.own()
    def run(self) -> int:
        """Races, shows the table, writes table and figure, and returns the exit code.

        Raises:
          RunError: an argument is wrong, or a file cannot be written.
        """
        self._check()
        from mjxwalk import engines
        from mjxwalk.runs import files

        engines.prepare()
        try:
            self.out.mkdir(parents=True, exist_ok=True)
            curves = self._curves()
            shown = table(curves)
            files.replace(self.out, "table.md", shown.encode())
            outputs.write_figure(self.out / "strategies.png", draw(curves))
        except OSError as error:
            raise RunError(f"{self.out} cannot be used: {error}") from None
        except ValueError as error:
            raise RunError(str(error)) from None
        print(shown, end="")
        print(f"{self.out / 'table.md'}\n{self.out / 'strategies.png'}")
        return 0

    def _check(self) -> None:
        from mjxwalk.strategies import FACTORIES

        for name in self.strategies:
            if name not in FACTORIES:
                raise RunError(f"unknown strategy {name!r}{near(name, list(FACTORIES))}")
        for name in self.experiments:
            if name not in experiments.names():
                raise RunError(f"unknown experiment {name!r}{near(name, experiments.names())}")
        for field in ("evaluations", "seeds", "million_steps"):
            if getattr(self, field) <= 0:
                flag = field.replace("_", "-")
                raise RunError(f"--{flag} must be above 0, got {getattr(self, field)}")
        if self.population < 0 or self.population % 2:
            raise RunError(f"--population must be 0 or even, got {self.population}")
        if any(number < 2 for number in self.weights):
            raise RunError(f"--weights must all be at least 2, got {min(self.weights)}")

    def _curves(self) -> list[Any]:
        from mjxwalk.bench import learning_curves

        done: list[Any] = []
        for number in self.weights:
            for name in self.strategies:
                file = f"{name}-{number}-{self.evaluations}-{self.seeds}.json"
                measure = functools.partial(
                    learning_curves.on_functions, name, number, self.seeds, self.evaluations
                )
                done += _kept(self.out, file, measure)
        for task in self.experiments:
            done += self._walkers(task)
        return done

    def _walkers(self, task: str) -> list[Any]:
        from mjxwalk.bench import learning_curves
        from mjxwalk.evaluation import Evaluator
        from mjxwalk.settings import override

        experiment: Any = experiments.get(task)
        if self.population:
            experiment = override(experiment, "population_size", str(self.population))
        evaluator = Evaluator(experiment, self.engine)
        done: list[Any] = []
        for name in self.strategies:
            chosen = learning_curves.with_strategy(experiment, name)
            kind = f"{name}-{task}-{experiment.population_size}-{self.million_steps:g}"
            for seed in range(self.seeds):
                measure = functools.partial(
                    learning_curves.on_walkers, chosen, evaluator, seed, self.million_steps
                )
                done += _kept(self.out, f"{kind}-{seed}.json", lambda measure=measure: [measure()])
        return done


def _kept(folder: Path, name: str, measure: Any) -> list[Any]:
    """Returns curves from their file in a folder, or runs them and writes it."""
    from mjxwalk.bench.learning_curves import LearningCurve
    from mjxwalk.runs import files

    path, content = folder / name, files.read_inside(folder, name)
    if content is None:
        content = json.dumps([one._asdict() for one in measure()]).encode()
        files.replace(folder, name, content)
        print(path, file=sys.stderr, flush=True)
    try:
        return [LearningCurve(**row) for row in files.decode(path, content, list)]
    except TypeError as error:
        raise RunError(f"{path} cannot be read: {error}") from None


def progress(curve: Any) -> Any:
    """Returns what a curve had reached at each effort.

    Of walkers, whose best fitness is a matter of luck and lost in a restart, that is the highest
    median of a few generations.
    """
    series = np.asarray(curve.reached)
    medians = [np.median(series[max(0, end - LATEST) : end]) for end in range(1, len(series) + 1)]
    return np.maximum.accumulate(medians)


def table(curves: list[Any]) -> str:
    """Returns medians and quartiles over the seeds, as Markdown."""
    tasks = list(dict.fromkeys(curve.task for curve in curves))
    names = list(dict.fromkeys(curve.strategy for curve in curves))
    lines = ["| task | " + " | ".join(names) + " |", "| --- |" + " --- |" * len(names)]
    for task in tasks:
        cells: list[str] = []
        for name in names:
            values = [
                progress(curve)[-1]
                for curve in curves
                if (curve.task, curve.strategy) == (task, name)
            ]
            low, middle, high = np.percentile(values, [25, 50, 75])
            cells.append(f"{middle:.2g} ({low:.2g} to {high:.2g})")
        lines.append(f"| {task} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def draw(curves: list[Any]) -> Any:
    """Returns a figure of what walkers reach against physics steps, and functions at their end."""
    from matplotlib.figure import Figure

    functions = [curve for curve in curves if len(curve.effort) == 1]
    walked = [curve for curve in curves if len(curve.effort) > 1]
    tasks = list(dict.fromkeys(curve.task for curve in walked))
    figure = Figure(figsize=(7, 3.2 * (len(tasks) + bool(functions))), layout="constrained")
    axes: Any = figure.subplots(len(tasks) + bool(functions), 1, squeeze=False)[:, 0]
    for axis, task in zip(axes, tasks, strict=False):
        _draw_walkers(axis, [curve for curve in walked if curve.task == task])
        axis.set_title(task)
    if functions:
        _draw_functions(axes[-1], functions)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _draw_walkers(axis: Any, curves: list[Any]) -> None:
    steps = np.linspace(0, max(curve.effort[-1] for curve in curves), 200)[1:]
    for name in dict.fromkeys(curve.strategy for curve in curves):
        fitness = np.array(
            [
                np.interp(steps, curve.effort, progress(curve))
                for curve in curves
                if curve.strategy == name
            ]
        )
        low, middle, high = np.percentile(fitness, [25, 50, 75], axis=0)
        (line,) = axis.plot(steps, middle, label=name)
        axis.fill_between(steps, low, high, color=line.get_color(), alpha=0.15, linewidth=0)
    axis.set_xlabel("million physics steps")
    axis.set_ylabel("best fitness")


def _draw_functions(axis: Any, curves: list[Any]) -> None:
    tasks = list(dict.fromkeys(curve.task for curve in curves))
    for name in dict.fromkeys(curve.strategy for curve in curves):
        found = [
            [curve.reached[-1] for curve in curves if (curve.task, curve.strategy) == (task, name)]
            for task in tasks
        ]
        medians = np.maximum([np.median(values) for values in found], 1e-8)
        axis.plot(medians, range(len(tasks)), "o", label=name, alpha=0.7)
    axis.set_yticks(range(len(tasks)), tasks, fontsize="small")
    axis.set_xscale("log")
    axis.set_xlabel("lowest value found, median")


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # small searches; leave the GPU to its owner
    sys.exit(cli.run("compare_strategies.py", CompareStrategies))
