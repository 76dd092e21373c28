"""Runs and studies in their folders: settings, evaluator and manifest, to the end or a stop.

What can be interrupted can be taken up again by its folder alone, to the same bits.
"""

import contextlib
import dataclasses
import functools
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import jax
import numpy as np

from mjxwalk import evaluation, tournament, walkers
from mjxwalk.engines import pinning
from mjxwalk.evolution import evolvable, loop
from mjxwalk.evolution.background_compile import BackgroundCompile
from mjxwalk.evolution.inheritance import inherit
from mjxwalk.evolution.processes import Processes
from mjxwalk.evolution.recorder import Recorder, RunRecorder
from mjxwalk.experiments import run_config, study_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.experiments.study_config import StudyConfig
from mjxwalk.progress import Progress
from mjxwalk.runs import RunError, config, folder, inheritance, manifest, result
from mjxwalk.runs.inheritance import Inherited

FEWEST_TERRAINS = 20  # ours: of a scaled-down study's tournament


@dataclasses.dataclass(frozen=True, kw_only=True)
class Runner:
    """Takes runs and studies to their end.

    All methods raise Interrupted if the user stopped them.

    Attributes:
      progress: shows them.
      stopping: whether to stop before the next generation.
      processes: that evolve a run together.
    """

    progress: Progress
    stopping: Callable[[], bool]
    processes: Processes = loop.ALONE

    def evolve_run(
        self,
        path: Path,
        settings: Config,
        inherited: Inherited | None,
        task: bytes | None = None,
    ) -> None:
        """Takes a new run to its end.

        Args:
          path: of its folder, which is made.
          settings: of the run.
          inherited: what it starts from; None for zero.
          task: text of a user's own task; None of our own experiments.

        Raises:
          RunError: the folder is taken, there is no such engine, or a file cannot be written.
        """
        evaluator = self.processes.share(_evaluator(settings, settings.engine))
        self.processes.check_same(settings)
        if task is not None:  # what the engine cannot compile is told before a folder is made
            _prepare(settings.experiment, evaluator)
        if self.processes.is_first:
            run_config.create(path, settings, inherited, task)
        self._evolve(path, settings, inherited, evaluator)

    def resume_run(self, path: Path) -> None:
        """Takes a run that was stopped to its end, or says that it is finished.

        Args:
          path: of its folder, which all processes see.

        Raises:
          RunError: the folder holds no run, or it cannot go on.
        """
        settings = run_config.read(path)
        finished = result.read(path)
        if finished is not None:
            if self.processes.is_first:
                self.progress.say(f"{path} is finished")
                self.progress.finish(path, settings, finished)
            return
        engine = manifest.engine(path, settings.engine)
        evaluator = self.processes.share(_evaluator(settings, engine))
        self.processes.check_same(settings)
        inherited = None if settings.experiment.start == "zero" else inheritance.read(path)
        self._evolve(path, settings, inherited, evaluator)

    def evolve_study(self, path: Path, study: StudyConfig) -> None:
        """Takes a new study through all of its phases.

        Raises:
          RunError: the folder is taken, there is no such engine, or a file cannot be written.
        """
        for number in range(len(study.phases)):
            settings = study.run(number)
            _evaluator(settings, settings.engine)  # refuses a wrong engine before all is made
        study_config.create(path, study)
        self.resume_study(path)

    def resume_study(self, path: Path) -> None:
        """Takes a study through the phases that are left; after each there is a tournament.

        Raises:
          RunError: the folder holds no study, or it cannot go on.
        """
        study = study_config.read(path)
        with folder.locked(path):
            for number, (name, _) in enumerate(study.phases):
                place = study.folder(path, number)
                is_begun = (place / config.FILE).exists()
                if is_begun:
                    study_config.check_phase(path, study, number)
                if not is_begun or result.read(place) is None:
                    self.progress.say(f"phase {number + 1} of {len(study.phases)}: {name}")
                if not is_begun:
                    self.evolve_run(place, *_start_phase(path, study, number))
                elif result.read(place) is None:
                    self.resume_run(place)
                if study.has_tournament(number) and tournament.read(place) is None:
                    hold_tournament(place, study, self.progress.say)
        self.progress.say(f"{study.name} is finished, in {path}")

    @pinning.pinned()
    def _evolve(
        self, path: Path, settings: Config, inherited: Inherited | None, evaluator: Any
    ) -> None:
        written = _recorder(path, settings, evaluator, self.progress)
        with (
            written if self.processes.is_first else contextlib.nullcontext(Recorder()) as recorder,
            _fine_trials(settings.experiment, evaluator.engine) as finer,
        ):
            loop.evolve(
                settings,
                evaluator,
                recorder,
                inherited=inherited,
                finer=finer,
                processes=self.processes,
                stopping=self.stopping,
            )


def hold_tournament(place: Path, study: StudyConfig, say: Callable[[str], None]) -> None:
    """Lets the last elites of a phase compete, and keeps the winner in its folder.

    Raises:
      RunError: the run cannot be read, or a file cannot be written.
    """
    entrants = walkers.entrants(place)
    figures = tournament.compete(
        entrants,
        engine=manifest.engine(place, study.engine),
        seed=study.seed,
        terrains=max(FEWEST_TERRAINS, round(study.scale * tournament.TERRAINS)),
        say=say,
    )
    tournament.write(place, figures, entrants.of_generation(figures.winner_generation))


def _start_phase(path: Path, study: StudyConfig, number: int) -> tuple[Config, Inherited | None]:
    settings = study.run(number)
    if settings.experiment.start == "zero":
        return settings, None
    before = study.folder(path, number - 1)
    inherited, origin = inherit(settings.experiment, before)
    # A neighbour, so that the study's folder can be moved.
    origin = dataclasses.replace(origin, source=f"../{before.name}")
    return dataclasses.replace(settings, origin=origin), inherited


def _evaluator(settings: Config, engine: str) -> Any:
    evolvable.check(settings.experiment)
    try:
        return evaluation.make_evaluator(settings.experiment, engine)
    except (ValueError, TypeError, OverflowError) as error:
        raise RunError(str(error)) from None


@pinning.pinned()
def _prepare(experiment: Any, evaluator: Any) -> None:
    """Compiles the trials of a generation."""
    strategy = experiment.make_strategy()

    def shapes(key: Any, template: Any) -> Any:
        population, _ = strategy.ask(key, strategy.init(key, template))
        return population, experiment.sample_trials(key, experiment.terrains_per_evaluation)

    evaluator.prepare(*jax.eval_shape(shapes, jax.random.key(0), experiment.template()))


@contextlib.contextmanager
def _recorder(
    path: Path, settings: Config, evaluator: Any, progress: Progress
) -> Generator[RunRecorder]:
    """Locks a run's folder, writes its manifest, and shows the run until it ends."""
    with folder.locked(path):
        if not (path / manifest.FILE).exists():
            manifest.write(
                path,
                engine=evaluator.engine,
                why=evaluator.why,
                devices=evaluator.devices,
                settings=pinning.settings(),
            )
        progress.start(path, settings, evaluator)
        try:
            with RunRecorder(path, settings, progress) as recorder:
                yield recorder
        finally:
            progress.close()
        finished = result.read(path)
        if finished is not None:
            progress.finish(path, settings, finished)


def _fine_trials(
    experiment: Any, engine: str
) -> contextlib.AbstractContextManager[BackgroundCompile | None]:
    """Returns what runs the goal's fine trials, None where there are none."""
    goal = experiment.goal
    if not goal.is_fine:
        return contextlib.nullcontext()
    make = functools.partial(evaluation.make_evaluator, experiment.finer(goal.fine_factor), engine)
    alone = jax.tree.map(lambda leaf: np.asarray(leaf)[None], experiment.template())
    trials = experiment.sample_trials(jax.random.key(0), goal.fine_trials)
    return BackgroundCompile(make, alone, trials)
