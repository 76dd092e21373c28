"""Compares the returns of many policies by an engine and in Gymnasium's own environments."""

import dataclasses
import os
import sys
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import tyro

from mjxwalk import cli, outputs, walkers
from mjxwalk.cli.argument_types import EngineName, Seed
from mjxwalk.errors import RunError, near

TASKS = ("Walker2d-v5", "Hopper-v5", "HalfCheetah-v5", "Ant-v5", "Humanoid-v5")
WEIGHTS = 0.3  # standard deviation of random policies' weights; ours: some saturate, some do not
HEADS = (
    *("task", "policies", "median, ours", "Gymnasium's", "quartiles, ours", "Gymnasium's"),
    *("terminated, ours", "Gymnasium's", "p"),
)
RunFolders = Annotated[tuple[str, ...], tyro.conf.arg(metavar="RUN ...")]
TaskNames = Annotated[tuple[str, ...], tyro.conf.arg(metavar="TASK ...")]


class Policies(NamedTuple):
    """Policies of one task: what they are in words, the task, and their weights [policy, ...]."""

    words: str
    task: Any
    controller: Any
    genotypes: Any


@dataclasses.dataclass(frozen=True, kw_only=True)
class GymnasiumReturns:
    """Compare returns of random policies, and of policies near champions, with Gymnasium's.

    Each policy plays an episode on either side, from another start.

    Attributes:
      tasks: in which random linear policies play.
      runs: of Gymnasium's tasks, whose champions' weights are changed at random.
      policies: of each kind.
      change: standard deviation of what is added to each of a champion's weights.
      seed: of weights and starts.
      engine: of ours.
      out: Markdown file to write the table to.
    """

    tasks: TaskNames = TASKS
    runs: RunFolders = ()
    policies: int = 100
    change: float = 0.02
    seed: Seed = 0
    engine: EngineName = "auto"
    out: Path = Path("gymnasium-returns.md")

    def run(self) -> int:
        """Plays, shows the table and writes it, and returns the exit code.

        Raises:
          RunError: an argument is wrong, Gymnasium is not installed, or the file cannot be written.
        """
        for name in self.tasks:
            if name not in TASKS:
                raise RunError(f"unknown task {name!r}{near(name, TASKS)}")
        if self.policies < 2:
            raise RunError(f"--policies must be at least 2, got {self.policies}")
        if not self.change >= 0.0:
            raise RunError(f"--change must not be negative, got {self.change}")
        for source in self.runs:
            walkers.check(source)
        outputs.check(self.out)
        try:
            kinds = [_random(name, self) for name in self.tasks]
            kinds += [_nearby(source, self) for source in self.runs]
        except ValueError as error:
            raise RunError(str(error)) from None
        lines = ["| " + " | ".join(HEADS) + " |", "| --- |" + " --- |" * (len(HEADS) - 1)]
        print("\n".join(lines), flush=True)
        for policies in kinds:
            lines.append(self._row(policies))
            print(lines[-1], flush=True)
        outputs.write(self.out, ("\n".join(lines) + "\n").encode())
        outputs.tell(self.out)
        return 0

    def _row(self, played: Policies) -> str:
        import jax

        from mjxwalk.verify import episodes, returns

        task, controller, genotypes = played.task, played.controller, played.genotypes
        trials = task.sample_trials(jax.random.key(self.seed), self.policies)
        own = episodes.in_engine(task, controller, genotypes, trials, self.engine)
        seeds = returns.seeds(self.seed, self.policies)
        theirs = episodes.in_gymnasium(task, controller, genotypes, seeds)
        sides = returns.side("ours", own), returns.side(returns.GYMNASIUM, theirs)
        p_value = returns.same_distribution(own.total, theirs.total)
        cells = (
            *(task.ID, played.words),
            *(f"{side.median:.1f}" for side in sides),
            *(f"{side.lower:.1f} to {side.upper:.1f}" for side in sides),
            *(f"{side.terminated_share:.0%}" for side in sides),
            f"{p_value:.2g}",
        )
        return "| " + " | ".join(cells) + " |"


def _random(name: str, asked: GymnasiumReturns) -> Policies:
    import jax

    from mjxwalk.controllers import LinearFeedback
    from mjxwalk.envs import gymnasium

    task = gymnasium.TASKS[name]()
    task.check_ready()
    controller: Any = LinearFeedback().on(task)
    leaves, tree = jax.tree.flatten(controller.template())
    rng = np.random.default_rng(asked.seed)
    drawn = [
        rng.normal(0.0, WEIGHTS, (asked.policies, *leaf.shape)).astype(np.float32)
        for leaf in leaves
    ]
    return Policies(f"{asked.policies} random", task, controller, jax.tree.unflatten(tree, drawn))


def _nearby(source: str, asked: GymnasiumReturns) -> Policies:
    import jax

    from mjxwalk.envs.gymnasium import GymnasiumTask
    from mjxwalk.verify import returns

    walker = walkers.best(source)
    if not isinstance(getattr(walker.experiment, "env", None), GymnasiumTask):
        raise RunError(f"{source} is no run of one of Gymnasium's tasks")
    task, rng = returns.as_gymnasium_has_it(walker), np.random.default_rng(asked.seed)
    controller = walker.experiment.controller.on(task)

    def changed(leaf: Any, may_change: Any) -> Any:
        noise = rng.normal(0.0, asked.change, (asked.policies, *np.shape(leaf)))
        return np.float32(np.asarray(leaf) + np.where(np.asarray(may_change), noise, 0.0))

    genotypes = jax.tree.map(changed, walker.genotype, controller.mask())
    return Policies(f"{asked.policies} near {walker.name}", task, controller, genotypes)


if __name__ == "__main__":
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # small batches; leave the GPU to its owner
    sys.exit(cli.run("gymnasium_returns.py", GymnasiumReturns))
