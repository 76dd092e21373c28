"""`mjxwalk evolve` and `mjxwalk resume`."""

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from mjxwalk import experiments
from mjxwalk.cli.parsing import CountOrAll, OptionalFloat, OptionalInt, OutPath, RunFolder
from mjxwalk.errors import Interrupted, RunError, near

if TYPE_CHECKING:
    from mjxwalk.cli.interrupt import Interrupt
    from mjxwalk.progress import Progress
    from mjxwalk.runs import Config

# Flags that stand for a setting of the experiment.
SETTINGS = {
    "generations": "generations",
    "population": "population_size",
    "terrains": "terrains_per_evaluation",
    "roughness": "env.terrain.roughness",
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Evolve:
    """Evolve walkers, in a folder of their own.

    Attributes:
      experiment: what to evolve; `mjxwalk list` shows all.
      seed: of all random numbers; the same seed gives the same run.
      generations: exactly so many, also where the experiment has a goal that ends it earlier.
      population: genotypes a generation.
      terrains: trials of each genotype, each on a terrain of its own.
      roughness: step of the random terrain, m.
      engine: what runs the trials; auto takes the fastest on this machine.
      out: folder of the run, new or empty.
      keep: newest checkpoints that stay on disk, or all.
      save_every: generations from one checkpoint to the next; a run resumes to the same bits
        whatever this is.
      set: any other setting, such as strategy.sigma=0.1.
    """

    experiment: tyro.conf.Positional[Annotated[str, tyro.conf.arg(metavar="EXPERIMENT")]] = (
        experiments.DEFAULT
    )
    seed: int = 0
    generations: OptionalInt = None
    population: OptionalInt = None
    terrains: OptionalInt = None
    roughness: OptionalFloat = None
    engine: Literal["auto", "mjx", "lanes", "lanes-xla"] = "auto"
    out: OutPath = None
    keep: CountOrAll = 20
    save_every: int = 1
    set: Annotated[
        tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar="PATH=VALUE")
    ] = ()

    def run(self) -> int:
        """Evolves and returns the exit code.

        Raises:
          RunError: an argument is wrong, or the run cannot go on.
        """
        self._check()
        from mjxwalk.runs import folder

        path = self.out or folder.default_path(self.experiment, self.seed)
        folder.check_free(path)
        return _work(path, self)

    def config(self) -> "Config":
        """Returns the settings of the run; imports JAX.

        Raises:
          RunError: a setting is unknown or has a wrong value.
        """
        from mjxwalk.runs import Config
        from mjxwalk.settings import override

        experiment: Any = experiments.get(self.experiment)
        for flag, path in SETTINGS.items():
            value = getattr(self, flag)
            if value is not None:
                experiment = override(experiment, path, str(value))
        if self.generations is not None:
            experiment = override(experiment, "goal.trials", "0")
        for assignment in self.set:
            path, _, value = assignment.partition("=")
            experiment = override(experiment, path.strip(), value.strip())
        try:
            experiment.make_strategy()  # checks the strategy's options
            return Config(
                experiment=experiment,
                seed=self.seed,
                engine=self.engine,
                keep=self.keep,
                save_every=self.save_every,
            )
        except (ValueError, TypeError) as error:
            raise RunError(str(error)) from None

    def _check(self) -> None:
        """Finds wrong arguments that can be found without the second that importing JAX takes."""
        known = experiments.names()
        if self.experiment not in known:
            raise RunError(f"unknown experiment {self.experiment!r}{near(self.experiment, known)}")
        for flag in ("generations", "population", "terrains", "keep", "save_every"):
            value = getattr(self, flag)
            if isinstance(value, int) and value < 1:
                raise RunError(f"--{flag.replace('_', '-')} must be at least 1, got {value}")
        for assignment in self.set:
            if "=" not in assignment:
                raise RunError(f"--set needs PATH=VALUE, got {assignment!r}")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Resume:
    """Go on with a run that was stopped, killed or out of disk, to the same bits.

    Attributes:
      run_folder: the run's folder.
    """

    run_folder: RunFolder

    def run(self) -> int:
        """Goes on with the run and returns the exit code.

        Raises:
          RunError: the folder is no run, or the run cannot go on.
        """
        from mjxwalk.runs import folder

        folder.check_run(self.run_folder)
        return _work(self.run_folder, None)


def _work(path: Path, new: Evolve | None) -> int:
    """Starts a run, or goes on with it, in a terminal."""
    from mjxwalk.cli.interrupt import Interrupt
    from mjxwalk.progress import make_progress

    progress = make_progress()
    with Interrupt(progress.say) as interrupt:
        try:
            return _work_interruptibly(path, new, progress, interrupt)
        except Interrupted as stop:
            progress.close()
            progress.say(f"{stop}; go on with: mjxwalk resume {path}")
        except KeyboardInterrupt:
            progress.close()
            begun = (path / "config.json").exists()
            progress.say(f"stopped; go on with: mjxwalk resume {path}" if begun else "stopped")
    return 128 + interrupt.signal


def _work_interruptibly(
    path: Path, new: Evolve | None, progress: "Progress", interrupt: "Interrupt"
) -> int:
    from mjxwalk import engines, evaluation, evolution
    from mjxwalk.runs import config, folder, manifest, result

    engines.prepare()
    settings = config.read(path) if new is None else new.config()
    finished = result.read(path)
    if finished is not None:
        progress.say(f"{path} is finished")
        progress.finish(path, settings, finished)
        return 0
    engine = settings.engine if new is not None else manifest.engine(path, settings.engine)
    try:
        evaluator = evaluation.make_evaluator(settings.experiment, engine)
    except ValueError as error:
        raise RunError(str(error)) from None
    if new is not None:
        folder.create(path, settings)
    with folder.locked(path):
        if not (path / manifest.FILE).exists():
            facts = (evaluator.engine, evaluator.why, evaluator.devices)
            manifest.write(path, engine=facts[0], why=facts[1], devices=facts[2])
        progress.start(path, settings, evaluator)
        try:
            outcome = evolution.evolve(path, settings, evaluator, progress, interrupt.requested)
        finally:
            progress.close()
        progress.finish(path, settings, outcome)
    return 0
