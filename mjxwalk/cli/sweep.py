"""`mjxwalk sweep`."""

import dataclasses
from pathlib import Path
from typing import Literal

from mjxwalk import experiments, shell
from mjxwalk.cli import main, own_body, sweep_grid
from mjxwalk.cli.argument_types import CoresOrShare, GigabytesOrAll, NameOrDefault, SweepPath
from mjxwalk.cli.evolve_arguments import EvolveArguments
from mjxwalk.errors import Interrupted, RunError
from mjxwalk.experiments import own_task
from mjxwalk.experiments.own_task import naming
from mjxwalk.runs import folder
from mjxwalk.sweep import plan as plans
from mjxwalk.sweep.jobs import LEAST_GB
from mjxwalk.sweep.plan import Plan, Resources


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sweep(EvolveArguments):
    """Evolve a grid of runs: every seed with every combination of settings, in one folder.

    The same command goes on with what it did not finish; runs that are finished stay as they are.
    All that `mjxwalk evolve` takes is taken for every run, and `--set PATH=V1,V2` tries each value.

    Attributes:
      out: folder of the sweep; without it one that the same grid finds again.
      seeds: runs of each combination of settings, with seeds from --seed upwards.
      executor: where runs run: in processes on this machine, in a Ray cluster, or as jobs of Slurm.
      cores_per_run: cores that each run gets; without it those of the machine, shared out.
      memory_per_run: gigabytes that each run may take.
      address: of the Ray cluster, such as auto or HOST:PORT.
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
        self.check()
        self._check_flags()
        plan = self._plan()
        path = self.out or folder.RUNS / f"sweep-{self.title.replace('/', '-')}-{plan.name}"
        folder.check_name(path)
        if not plans.is_sweep(path):
            self._choose()
        plans.create(path, plan)
        return go_on(path, plan)

    def _check_flags(self) -> None:
        """Finds what `evolve` takes and a sweep does not."""
        if self.experiment in experiments.studies():
            phases = ", ".join(experiments.phases(self.experiment))
            raise RunError(f"{self.experiment} is a study; sweep one of its phases {phases}")
        if self.distributed:
            raise RunError("a sweep gives each run one process; --distributed is for `evolve`")
        if self.live:
            raise RunError(
                "--live shows one run, and a sweep has several at a time; watch one of them by "
                "`mjxwalk watch RUN`"
            )
        for flag, executor in (("address", "ray"), ("partition", "slurm")):
            if getattr(self, flag) is not None and self.executor != executor:
                raise RunError(f"--{flag} goes with --executor {executor}")
        for flag in ("cores_per_run", "memory_per_run", "hours"):
            value = getattr(self, flag)
            if value is not None and not 0 < value < float("inf"):
                raise RunError(f"--{flag.replace('_', '-')} must be above 0, got {value}")
        if self.memory_per_run is not None and self.memory_per_run < LEAST_GB:
            raise RunError(
                f"--memory-per-run must be at least {LEAST_GB} GB, which JAX takes for itself, got "
                f"{self.memory_per_run}"
            )

    def _plan(self) -> Plan:
        resources = Resources(
            executor=self.executor,
            cores=self.cores_per_run,
            memory_gb=self.memory_per_run,
            address=self.address,
            partition=self.partition,
            hours=self.hours,
        )
        return sweep_grid.make_plan(self.anywhere(), self.seeds, resources)

    def anywhere(self) -> EvolveArguments:
        """Returns what is asked for with whole paths, to be gone on with from any folder."""
        from mjxwalk import walkers

        source, body, links = self.source, self.body, self.links
        if source is not None and not walkers.in_zoo(source):
            source = str(Path(source).absolute())
        experiment, sha256 = self.experiment, self.task_sha256
        if self.is_task:
            named, file = own_task.find(experiment)
            sha256 = naming.read(file).sha256
            experiment = f"{file.absolute()}{':' if named.name else ''}{named.name}"
        return dataclasses.replace(
            self,
            experiment=experiment,
            task_sha256=sha256,
            source=source,
            body=body if body is None or own_body.is_shipped(body) else body.absolute(),
            links=links and links.absolute(),
        )

    def _choose(self) -> None:
        """Finds what is wrong with a run's settings before any run begins.

        Raises:
          RunError: some run would be refused, or two would be the same.
        """
        import jax

        # This process only looks at settings; a GPU is for the runs.
        jax.config.update("jax_platforms", "cpu")
        from mjxwalk.cli.choosing import choose_run
        from mjxwalk.experiments import run_config

        seen: dict[bytes, str] = {}
        for asked in sweep_grid.grid(self, 1).values():
            settings = choose_run(asked).settings
            given, content = " ".join(asked.set), run_config.text(settings)
            if content in seen:
                raise RunError(f"{seen[content]} and {given} are the same run; leave one out")
            seen[content] = given


def go_on(path: Path, plan: Plan) -> int:
    """Takes a sweep to its end in a terminal, and returns the exit code.

    Raises:
      RunError: its executor is not there, or a run failed.
    """
    from mjxwalk.cli import sweep_display
    from mjxwalk.cli.interrupt import Interrupt
    from mjxwalk.sweep import reporting, running

    display = sweep_display.make_display()
    with Interrupt(display.say) as interrupt:
        try:
            rows = running.go_on(path, plan, display, interrupt.requested, main)
        except (Interrupted, KeyboardInterrupt) as stop:
            display.close()
            display.say(f"{stop or 'stopped'}; go on with: {shell.command('resume', path)}")
            return 128 + interrupt.signal
    display.say(sweep_display.summary(rows, None))
    running.check_ended(path, rows)
    display.say(f"in {path}")
    for number, line in enumerate(reporting.commands(path, plan)):
        display.say(f"{'      ' if number else 'next: '}{line}")
    return 0
