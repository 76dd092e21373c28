"""The arguments of `mjxwalk evolve`, which `mjxwalk sweep` takes too; imports no JAX."""

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mjxwalk import experiments, terminal
from mjxwalk.cli import own_body
from mjxwalk.cli.argument_types import (
    ContactLaw,
    CountOrAll,
    DigestOrAny,
    EngineName,
    NameOrCluster,
    NumberOrCluster,
    OptionalFloat,
    OptionalInt,
    OptionalName,
    OutPath,
    Seed,
)
from mjxwalk.cli.following import Following
from mjxwalk.errors import RunError, near
from mjxwalk.experiments import own_task
from mjxwalk.experiments.scaling import LARGEST
from mjxwalk.runs import folder

if TYPE_CHECKING:
    from mjxwalk.evolution.processes import Processes


COUNTS = ("generations", "population", "terrains", "keep", "save_every", "most_steps")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Together:
    """Arguments of a run that several processes share, on one machine or many.

    Attributes:
      distributed: evaluate a part of each population, while the other processes that were given
        this same command evaluate the others.
      coordinator: HOST:PORT of the first process (detected under Slurm, Open MPI, TPU).
      processes: total number of processes (detected under Slurm, Open MPI, TPU).
      process: number of this process; number 0 writes the run (detected under Slurm, Open MPI,
        TPU).
    """

    distributed: bool = False
    coordinator: NameOrCluster = None
    processes: NumberOrCluster = None
    process: NumberOrCluster = None

    def join(self) -> "Processes":
        """Waits for the other processes, if there are any, and returns them.

        Raises:
          RunError: they cannot be reached.
        """
        from mjxwalk.evolution import distributed, processes

        if not self.distributed:
            return processes.Processes()
        return distributed.join(self.coordinator, self.processes, self.process)

    def check_together(self) -> None:
        """Raises RunError if other processes are described, and --distributed is not given."""
        for flag in ("coordinator", "processes", "process"):
            if getattr(self, flag) is not None and not self.distributed:
                raise RunError(f"--{flag} is for a run of several processes; add --distributed")


@dataclasses.dataclass(frozen=True, kw_only=True)
class EvolveArguments(Together, Following):
    """What to evolve, and how.

    Attributes:
      experiment: what to evolve, an experiment, a study or one of its phases; `mjxwalk list` shows
        all. Where none is named it is planar-lpd, and with --body the experiment walk. Or a task of
        your own in Python: FILE.py, FILE.py:NAME or MODULE:NAME; docs/own-task.md tells more.
      seed: of all random numbers; the same seed gives the same run.
      trust: execute the code of the run of --from, which somebody else wrote.
      most_steps: of a task of your own: a trial that has not ended by then is taken for one that
        never does.
      task_sha256: DigestOrAny = None
      source: run to start from, its folder or `zoo:NAME`; walkers start around its winner, or go on
        with its population if that is what the experiment does.
      scale: factor on populations and generations, for a quick look.
      generations: exactly so many, also where the experiment has a goal that ends it earlier.
      strategy: what to evolve with in place of the experiment's own, such as sep-cma-es; it keeps
        those of its settings that it takes too. `--set strategy.NAME=VALUE` gives it others.
      population: genotypes a generation.
      terrains: trials of each genotype, each on a terrain of its own.
      roughness: step of the random terrain, m.
      body: MJCF or URDF file of your own body, the name of one that ships (`mjxwalk list`), or a
        run that has one; docs/any-body.md tells more.
      controller: what decides in place of the experiment's own controller: linear, mlp, recurrent,
        ctrnn or harmonics; `--set controller.NAME=VALUE` gives it other settings.
      contact: contact law of a body of --body: points, springs and dampers at its feet, or mujoco,
        MuJoCo's own contacts and solver, some ten times slower.
      links: JSON file with the inputs that each network sees besides its own angle, rate and bias.
      engine: what runs the trials; auto takes the fastest on this machine.
      out: folder of the run, new or empty.
      keep: newest checkpoints that stay on disk, or all.
      save_every: generations from one checkpoint to the next, 1 or what the experiment asks for; a
        run resumes to the same bits whatever this is.
      set: any other setting, such as strategy.sigma=0.1; of a study behind the phase's name, such
        as fil.strategy.sigma=0.1.
    """

    experiment: tyro.conf.Positional[Annotated[str, tyro.conf.arg(metavar="EXPERIMENT")]] = ""
    seed: Seed = 0
    source: Annotated[str | None, tyro.conf.arg(name="from", metavar="RUN")] = None
    scale: float = 1.0
    generations: OptionalInt = None
    strategy: OptionalName = None
    population: OptionalInt = None
    terrains: OptionalInt = None
    roughness: OptionalFloat = None
    body: Annotated[Path | None, tyro.conf.arg(metavar="FILE|NAME|RUN")] = None
    controller: OptionalName = None
    contact: ContactLaw = None
    links: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    engine: EngineName = "auto"
    out: OutPath = None
    keep: CountOrAll = 20
    save_every: OptionalInt = None
    set: Annotated[
        tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar="PATH=VALUE")
    ] = ()
    trust: bool = False
    most_steps: int = 1_000_000
    task_sha256: DigestOrAny = None

    @property
    def is_task(self) -> bool:
        """Whether what is evolved is a user's own task."""
        return own_task.is_task(self.experiment)

    @property
    def title(self) -> str:
        """What is evolved, as a part of a folder's name."""
        return own_task.find(self.experiment)[0].title if self.is_task else self.experiment

    def __post_init__(self) -> None:
        if not self.experiment:
            is_any = self.body is not None or self.controller is not None
            usual = experiments.ANY_BODY if is_any else experiments.DEFAULT
            object.__setattr__(self, "experiment", usual)

        name, plus, controller = self.experiment.partition("+")  # as runs are named
        if plus and self.controller is None and not self.is_task:
            object.__setattr__(self, "experiment", name)
            object.__setattr__(self, "controller", controller)

    def check(self) -> None:
        """Finds wrong arguments that can be found without the second that importing JAX takes."""
        self.check_following()
        self.check_together()
        known = [*experiments.names(), *experiments.studies()]
        if self.is_task:
            self._check_task()
        elif self.experiment not in known:
            raise RunError(f"unknown experiment {self.experiment!r}{near(self.experiment, known)}")
        if self.controller is not None and self.controller not in experiments.CONTROLLERS:
            raise RunError(
                f"unknown controller {self.controller!r}"
                f"{near(self.controller, experiments.CONTROLLERS)}"
            )
        for flag in COUNTS:
            value = getattr(self, flag)
            if isinstance(value, int) and value < 1:
                raise RunError(f"--{flag.replace('_', '-')} must be at least 1, got {value}")
        if not 0 < self.scale <= LARGEST:
            raise RunError(
                f"--scale must be a number above 0 and at most {LARGEST:g}, got {self.scale}"
            )
        if self.body is not None:
            own_body.check(self.body)
        for assignment in self.set:
            if "=" not in assignment:
                raise RunError(f"--set needs PATH=VALUE, got {assignment!r}")
            if terminal.has_other_bytes(assignment):
                raise RunError(f"--set {assignment!r} must be UTF-8 text, to be kept in a file")
        if self.experiment in experiments.studies():
            self._check_study()
        if self.source is not None and not self.source.startswith(folder.ZOO):
            own_task.trust.check_run(Path(self.source), is_given=self.trust)

    def _check_task(self) -> None:
        """Raises RunError unless the file of a user's own task is there and is Python."""
        from mjxwalk.experiments.own_task import naming

        _, path = own_task.find(self.experiment)
        naming.check_syntax(naming.read(path))

    def _check_study(self) -> None:
        phases = ", ".join(experiments.phases(self.experiment))
        if self.distributed:
            raise RunError(
                f"{self.experiment} is a study; --distributed is for one of its phases {phases}"
            )
        if self.source is not None:
            raise RunError(
                f"{self.experiment} is a study and starts from zero; --from is for one of its "
                f"phases {phases}"
            )
        for flag in ("strategy", "controller"):
            if getattr(self, flag) is None:
                continue
            raise RunError(
                f"{self.experiment} is a study; --{flag} is for one of its phases {phases}"
            )
        if self.generations is not None:
            raise RunError(
                f"{self.experiment} is a study whose phases {phases} have generations of their "
                "own; use --scale, or --set PHASE.generations=NUMBER"
            )
