"""Compares controllers on one body, ground and budget: which walks, how soon, how robustly."""

import contextlib
import dataclasses
import io
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mjxwalk import cli, outputs, walkers
from mjxwalk.analysis import style
from mjxwalk.errors import RunError, near
from mjxwalk.runs import files, result

# Goal, effort and ends of planar-lpd, for experiments that have others; 256,000 trials at most.
SAME = (
    *("goal.trials=200", "goal.duration=30", "goal.distance=20", "goal.fine_trials=50"),
    *("population_size=640", "terrains_per_evaluation=1", "generations=400"),
    *("restart_after=40", "restart_below=10", "restart_at=100"),
)


class Contender(NamedTuple):
    """A controller: the experiment that it decides in, what it is, and other settings."""

    experiment: str
    controller: str = ""
    settings: tuple[str, ...] = ()


CONTENDERS: Mapping[str, Contender] = {
    "LPD": Contender("planar-lpd"),
    "FIL": Contender("planar-fil", settings=SAME),
    "linear": Contender("planar-lpd", "linear"),
    "perceptron": Contender("planar-lpd", "mlp"),
    "recurrent": Contender("planar-lpd", "recurrent"),
    "CTRNN": Contender("planar-lpd", "ctrnn"),
    "CTRNN, blind": Contender("planar-lpd", "ctrnn", ("controller.feels=false",)),
    "harmonics": Contender("planar-lpd", "harmonics"),
    "Rayleigh": Contender("rayleigh-walk", settings=SAME),
}
CONDITIONS = ("as evolved", "half the step", "twice as rough", "other starts")


class Row(NamedTuple):
    """What a run came to.

    Attributes:
      steps: of the physics until its end, in millions.
      reached: whether that was its goal.
      weights: that it evolved.
      cost: of transport, of trials as evolved.
      falls: share of trials that end by a fall, by condition.
    """

    steps: float
    reached: bool
    weights: int
    cost: float
    falls: dict[str, float]


@dataclasses.dataclass(frozen=True, kw_only=True)
class CompareControllers:
    """Compare controllers of the planar walker. Runs that are finished are not made again.

    Attributes:
      out: folder of the runs, the table and the figure.
      contenders: by name.
      seeds: of each, from 1.
      trials: of each champion in each condition.
      engine: that runs the walkers.
    """

    out: Path = Path("controllers")
    contenders: tuple[str, ...] = tuple(CONTENDERS)
    seeds: int = 10
    trials: int = 500
    engine: str = "auto"

    @style.own()
    def run(self) -> int:
        """Evolves, tries the champions, shows the table, and returns the exit code.

        Raises:
          RunError: an argument is wrong, or a file cannot be written.
        """
        for name in self.contenders:
            if name not in CONTENDERS:
                raise RunError(f"unknown contender {name!r}{near(name, list(CONTENDERS))}")
        for flag in ("seeds", "trials"):
            if getattr(self, flag) < 1:
                raise RunError(f"--{flag} must be at least 1, got {getattr(self, flag)}")
        rows = {
            name: [self._row(self._evolved(name, seed)) for seed in range(1, self.seeds + 1)]
            for name in self.contenders
        }
        shown = table(rows)
        files.replace(self.out, "table.md", shown.encode())
        outputs.write_figure(self.out / "controllers.png", draw(rows))
        print(shown, end="")
        print(f"{self.out / 'table.md'}\n{self.out / 'controllers.png'}")
        return 0

    def _evolved(self, name: str, seed: int) -> Path:
        """Returns the folder of a finished run."""
        asked = CONTENDERS[name]
        folder = self.out / f"{name.lower().replace(', ', '-')}-{seed}"
        if folder.exists() and result.read(folder) is not None:
            return folder
        words = ["resume", str(folder)]
        if not folder.exists():
            words = ["evolve", asked.experiment, "--seed", str(seed), "--out", str(folder)]
            words += ["--controller", asked.controller] if asked.controller else []
            words += [part for setting in asked.settings for part in ("--set", setting)]
        print(f"mjxwalk {' '.join(words)}", file=sys.stderr, flush=True)
        with contextlib.redirect_stdout(io.StringIO()):
            code = cli.main(words)
        if code:
            raise RunError(f"{folder} did not end: exit code {code}")
        return folder

    def _row(self, folder: Path) -> Row:
        """Returns what a run's champion does in new trials."""
        import jax

        from mjxwalk.evaluation import evaluate
        from mjxwalk.outcomes import cost_of_transport

        walker = walkers.best(folder)
        experiment: Any = walker.experiment
        env, finished = experiment.env, result.read(folder)
        assert finished is not None  # or it would not be here
        alone = jax.tree.map(lambda leaf: np.asarray(leaf)[None], walker.genotype)
        key, key_starts = jax.random.split(jax.random.key(2**31))  # of no run's seed
        plain = env.sample_trials(key, self.trials)
        rough = env.sample_trials(key, self.trials, 2 * env.terrain.roughness)
        given = (
            (env, plain),
            (experiment.finer(2).env, plain),
            (env, rough),
            env.perturbed(key_starts, plain),
        )
        outcomes = [
            evaluate(ground, experiment.controller, alone, trials, engine=self.engine)
            for ground, trials in given
        ]
        mask = jax.tree.leaves(experiment.controller.mask())
        cost = cost_of_transport(outcomes[0].work, outcomes[0].distance, experiment.weight)
        return Row(
            steps=finished.physics_steps / 1e6,
            reached=finished.generations < experiment.generations,
            weights=int(sum(np.sum(np.asarray(leaf)) for leaf in mask)),
            cost=np.nan if cost is None else cost,
            falls={
                name: float(np.mean(outcome.fell))
                for name, outcome in zip(CONDITIONS, outcomes, strict=True)
            },
        )


def table(rows: Mapping[str, list[Row]]) -> str:
    """Returns medians over the seeds, with quartiles of steps, as Markdown.

    Falls and cost are of the runs that reached their goal.
    """
    heads = ("controller", "weights", "reached", "million steps", *CONDITIONS, "cost")
    lines = ["| " + " | ".join(heads) + " |", "| --- |" + " --- |" * (len(heads) - 1)]
    for name, own in rows.items():
        walked = [row for row in own if row.reached]
        cells = [name, f"{own[0].weights}", f"{len(walked)} of {len(own)}"]
        if walked:
            low, middle, high = np.percentile([row.steps for row in walked], [25, 50, 75])
            cells.append(f"{middle:.0f} ({low:.0f} to {high:.0f})")
            cells += [f"{np.median([row.falls[c] for row in walked]):.1%}" for c in CONDITIONS]
            cells.append(f"{np.median([row.cost for row in walked]):.2f}")
        else:
            cells += ["-"] * (len(heads) - len(cells))
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def draw(rows: Mapping[str, list[Row]]) -> Any:
    """Returns a figure of the seeds at the goal over the steps, and of the falls by condition."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 6.5), layout="constrained")
    soon, robust = figure.subplots(2, 1)
    for name, own in rows.items():
        steps = sorted(row.steps for row in own if row.reached)
        share = np.arange(len(steps) + 1) / len(own)
        soon.step([0.1, *steps], share, where="post", label=name)
    soon.set_xscale("log")
    soon.set_xlabel("million physics steps")
    soon.set_ylabel("share of seeds at the goal")
    width = 0.8 / len(CONDITIONS)
    for place, condition in enumerate(CONDITIONS):
        falls = [
            100 * np.median([row.falls[condition] for row in own if row.reached] or [np.nan])
            for own in rows.values()
        ]
        robust.bar(np.arange(len(rows)) + place * width, falls, width, label=condition)
    places = np.arange(len(rows)) + 0.4 - width / 2
    robust.set_xticks(places, list(rows), fontsize="small", rotation=20, ha="right")
    robust.set_ylabel("falls (%)")
    robust.legend(fontsize="small")
    soon.legend(fontsize="small")
    return figure


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # small searches; leave the GPU to its owner
    sys.exit(cli.run("compare_controllers.py", CompareControllers))
