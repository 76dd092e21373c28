"""Runs and studies in their folders: settings, evaluator and manifest, to the end or a stop.

What can be interrupted can be taken up again by its folder alone, to the same bits.
"""

import dataclasses
import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mjxwalk import evaluation, tournament, walkers
from mjxwalk.engines import pinning
from mjxwalk.evolution import loop, memory, starting, team
from mjxwalk.experiments import run_config, study_config
from mjxwalk.experiments.run_config import Config
from mjxwalk.experiments.study_config import StudyConfig
from mjxwalk.progress import Progress
from mjxwalk.runs import RunError, config, folder, manifest, result, start
from mjxwalk.runs.start import Start

FEWEST_TERRAINS = 20  # ours: of a scaled-down study's tournament


def begin(
    path: Path,
    settings: Config,
    given: Start | None,
    progress: Progress,
    stopping: Callable[[], bool],
    *,
    is_shared: bool = False,
) -> None:
    """Takes a new run to its end.

    Args:
      path: of its folder, which is made.
      settings: of the run.
      given: what it starts from; None for zero.
      progress: shows it.
      stopping: whether to stop before the next generation.
      is_shared: whether other processes, which `team.join` has found, work along.

    Raises:
      RunError: the folder is taken, there is no such engine, or a file cannot be written.
      Interrupted: the user stopped it.
    """
    evaluator = _evaluator(settings, settings.engine)
    if is_shared:
        evaluator = team.Shared(evaluator)
        team.check_same(settings)
        if not team.is_first():
            team.follow(settings, given, evaluator, stopping, _make_finer(settings, evaluator))
            return
    run_config.create(path, settings, given)
    _go_on(path, settings, evaluator, progress, stopping, is_shared)


def resume(
    path: Path, progress: Progress, stopping: Callable[[], bool], *, is_shared: bool = False
) -> None:
    """Takes a run that was stopped to its end, or says that it is finished.

    Args:
      path: of its folder, which all processes see.
      progress: shows it.
      stopping: whether to stop before the next generation.
      is_shared: whether other processes, which `team.join` has found, work along.

    Raises:
      RunError: the folder holds no run, or it cannot go on.
      Interrupted: the user stopped it.
    """
    settings = run_config.read(path)
    finished = result.read(path)
    if finished is not None:
        if is_shared and not team.is_first():
            return
        progress.say(f"{path} is finished")
        progress.finish(path, settings, finished)
        return
    evaluator = _evaluator(settings, manifest.engine(path, settings.engine))
    if is_shared:
        evaluator = team.Shared(evaluator)
        team.check_same(settings)
        if not team.is_first():
            given = None if settings.experiment.start == "zero" else start.read(path)
            team.follow(settings, given, evaluator, stopping, _make_finer(settings, evaluator))
            return
    _go_on(path, settings, evaluator, progress, stopping, is_shared)


def begin_study(
    path: Path, study: StudyConfig, progress: Progress, stopping: Callable[[], bool]
) -> None:
    """Takes a new study through all of its phases.

    Raises:
      RunError: the folder is taken, there is no such engine, or a file cannot be written.
      Interrupted: the user stopped it.
    """
    for number in range(len(study.phases)):
        settings = study.run(number)
        _evaluator(settings, settings.engine)  # refuses a wrong engine before anything is made
    study_config.create(path, study)
    resume_study(path, progress, stopping)


def resume_study(path: Path, progress: Progress, stopping: Callable[[], bool]) -> None:
    """Takes a study through the phases that are left; after each there is a tournament.

    Raises:
      RunError: the folder holds no study, or it cannot go on.
      Interrupted: the user stopped it.
    """
    study = study_config.read(path)
    with folder.locked(path):
        for number, (name, _) in enumerate(study.phases):
            place = study.folder(path, number)
            is_begun = (place / config.FILE).exists()
            if is_begun:
                study_config.check_phase(path, study, number)
            if not is_begun or result.read(place) is None:
                progress.say(f"phase {number + 1} of {len(study.phases)}: {name}")
            if not is_begun:
                settings, given = _start_phase(path, study, number)
                begin(place, settings, given, progress, stopping)
            elif result.read(place) is None:
                resume(place, progress, stopping)
            if study.has_tournament(number) and tournament.read(place) is None:
                hold_tournament(place, study, progress.say)
    progress.say(f"{study.name} is finished, in {path}")


def hold_tournament(place: Path, study: StudyConfig, say: Callable[[str], None]) -> None:
    """Lets the last elites of a phase compete, and keeps the winner in its folder.

    Raises:
      RunError: the run cannot be read, or a file cannot be written.
    """
    entrants = walkers.entrants(place)
    held = tournament.hold(
        entrants,
        engine=manifest.engine(place, study.engine),
        seed=study.seed,
        terrains=max(FEWEST_TERRAINS, round(study.scale * tournament.TERRAINS)),
        say=say,
    )
    tournament.write(place, held, entrants.of_generation(held.winner_generation))


def _start_phase(path: Path, study: StudyConfig, number: int) -> tuple[Config, Start | None]:
    settings = study.run(number)
    if settings.experiment.start == "zero":
        return settings, None
    before = study.folder(path, number - 1)
    given, origin = starting.prepare(settings.experiment, before)
    # A neighbour, so that the study's folder can be moved.
    origin = dataclasses.replace(origin, source=f"../{before.name}")
    return dataclasses.replace(settings, origin=origin), given


def _evaluator(settings: Config, engine: str) -> Any:
    memory.check_settings(settings.experiment)
    try:
        settings.experiment.make_strategy()  # checks its options, which a file may have any in
        return evaluation.make_evaluator(settings.experiment, engine)
    except (ValueError, TypeError, OverflowError) as error:
        raise RunError(str(error)) from None


def _make_finer(settings: Config, evaluator: Any) -> Callable[[], Any] | None:
    """Returns what makes the evaluator of the goal's fine trials, None where there are none."""
    experiment = settings.experiment
    if not experiment.goal.is_fine:
        return None
    finer = experiment.finer(experiment.goal.fine_factor)
    return functools.partial(evaluation.make_evaluator, finer, evaluator.engine)


@pinning.pinned()
def _go_on(
    path: Path,
    settings: Config,
    evaluator: Any,
    progress: Progress,
    stopping: Callable[[], bool],
    is_shared: bool = False,
) -> None:
    make_finer = _make_finer(settings, evaluator)
    share = team.first_of if is_shared else None
    stopping = team.any_of(stopping) if is_shared else stopping
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
            outcome = loop.evolve(path, settings, evaluator, progress, stopping, make_finer, share)
        finally:
            progress.close()
        progress.finish(path, settings, outcome)
