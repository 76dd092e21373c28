"""`mjxwalk sweep`."""

import dataclasses
from pathlib import Path
from typing import Literal

from mjxwalk import experiments
from mjxwalk.cli.evolve import Evolve
from mjxwalk.cli.parsing import CoresOrShare, GigabytesOrAll, NameOrDefault, SweepPath
from mjxwalk.errors import Interrupted, RunError
from mjxwalk.runs.folder import RUNS
from mjxwalk.sweep import plan as plans
from mjxwalk.sweep.grid import grid
from mjxwalk.sweep.plan import Plan, Resources


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sweep(Evolve):
    """Evolve a grid of runs: every seed with every combination of settings, in one folder.

    The same command goes on with what it did not finish; runs that are finished stay as they are.
    All that `mjxwalk evolve` takes is taken for every run, and `--set PATH=V1,V2` tries each value.

    Attributes:
      out: folder of the sweep; without it one that the same grid finds again.
      seeds: runs of each combination of settings, with seeds from --seed upwards.
      executor: where runs run: in processes on this machine, in a Ray cluster, or as jobs of Slurm.
      cores_per_run: cores that each run gets; without it those of the machine, shared out.
      memory_per_run: gigabytes that each run may take.
      address: of the Ray cluster, such as auto or ray://HOST:PORT.
      partition: of Slurm.
      hours: that a job of Slurm may take; what it does not finish is gone on with.
    """

    out: SweepPath = None
    seeds: int = 4
    executor: Literal["local", "ray", "slurm"] = "local"
    cores_per_run: CoresOrShare = None
    memory_per_run: GigabytesOrAll = None
    address: NameOrDefault = None
    partition: NameOrDefault = None
    hours: float = 24.0

    def run(self) -> int:
        """Runs what is not finished and returns the exit code.

        Raises:
          RunError: an argument is wrong, an executor is not there, or a run failed.
        """
        self._check()
        plan = self._plan()
        path = self.out or RUNS / f"sweep-{self.experiment.replace('/', '-')}-{plan.name}"
        if not plans.is_sweep(path):
            self._choose(plan)
        plans.create(path, plan)
        return go_on(path, plan)

    def _plan(self) -> Plan:
        if self.experiment in experiments.studies():
            phases = ", ".join(experiments.phases(self.experiment))
            raise RunError(f"{self.experiment} is a study; sweep one of its phases {phases}")
        if self.distributed:
            raise RunError("a sweep gives each run one process; --distributed is for `evolve`")
        for flag in ("cores_per_run", "memory_per_run", "hours"):
            value = getattr(self, flag)
            if value is not None and not 0 < value < float("inf"):
                raise RunError(f"--{flag.replace('_', '-')} must be above 0, got {value}")
        resources = Resources(
            executor=self.executor,
            cores=self.cores_per_run,
            memory_gb=self.memory_per_run,
            address=self.address,
            partition=self.partition,
            hours=self.hours,
        )
        return plans.make(grid(self, self.seeds), resources)

    def _choose(self, plan: Plan) -> None:
        """Finds what is wrong with a run's settings before any run begins."""
        import jax

        # This process only looks at settings; a GPU is for the runs.
        jax.config.update("jax_platforms", "cpu")
        from mjxwalk.cli.choosing import choose_run

        seen: set[tuple[str, ...]] = set()
        for asked in grid(self, 1).values():
            if asked.set not in seen:
                choose_run(asked)
            seen.add(asked.set)


def go_on(path: Path, plan: Plan) -> int:
    """Takes a sweep to its end in a terminal, and returns the exit code.

    Raises:
      RunError: its executor is not there, or a run failed.
    """
    from mjxwalk.cli.interrupt import Interrupt
    from mjxwalk.sweep import running, showing

    display = showing.make_display()
    with Interrupt(display.say) as interrupt:
        try:
            rows = running.go_on(path, plan, display, interrupt.requested)
        except (Interrupted, KeyboardInterrupt) as stop:
            display.close()
            display.say(f"{stop or 'stopped'}; go on with: mjxwalk resume {path}")
            return 128 + interrupt.signal
    display.say(showing.summary(rows, None))
    running.check_ended(path, rows)
    display.say(f"in {path}")
    display.say(f"next: mjxwalk report {path}/*seed-*")
    return 0
