"""What a report is about: runs and studies, read from their folders; imports JAX."""

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mjxwalk import runs, settings, shell, terminal, tournament, walkers
from mjxwalk.analysis import roles
from mjxwalk.envs.anatomy import anatomy_of
from mjxwalk.errors import RunError
from mjxwalk.experiments import study_config
from mjxwalk.experiments.study_config import StudyConfig
from mjxwalk.runs import config, folder, metrics, study
from mjxwalk.tournament import Tournament
from mjxwalk.walker import Walker


@dataclasses.dataclass(frozen=True, kw_only=True)
class Phase:
    """A run, alone or as one phase of a study; it has a generation at least.

    Attributes:
      name: of the phase, such as "lpd", or of an experiment that is no phase.
      study: that the experiment is a phase of; None for none.
      run: its files.
      experiment: that was evolved.
      walker: its best.
      tournament: that the walker won; None without one, or if the run has gone on since.
      is_running: whether a process is working on it.
      is_between: whether it only leads to the next phase of its study, so that nobody asks which of
        its walkers is best.
    """

    name: str
    study: str | None
    run: runs.Run
    experiment: Any
    walker: Walker
    tournament: Tournament | None
    is_running: bool
    is_between: bool = False

    @property
    def label(self) -> str:
        """The folder, as text to show."""
        return shown(self.run.path)

    @property
    def seed(self) -> int:
        """Of all its random numbers."""
        return int(self.run.config["seed"])

    @property
    def is_finished(self) -> bool:
        """Whether it came to its end."""
        return self.run.result is not None

    @property
    def is_paper(self) -> bool:
        """Whether its walkers have a body of Solomon, Locascio & Hartmann (2013)."""
        known = roles.roles_of(getattr(self.experiment, "env", None))
        return known is not None and known.is_paper

    @property
    def body(self) -> str:
        """Name of the body, as text to show; "" of an experiment without one."""
        known = anatomy_of(getattr(self.experiment, "env", None))
        return "" if known is None else terminal.one_line(known.name)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Source:
    """One of the folders that a report was asked for.

    Attributes:
      path: of the folder.
      study: its settings; None for a run alone.
      phases: that have a generation, first to last.
      missing: names of the others.
    """

    path: Path
    study: StudyConfig | None
    phases: tuple[Phase, ...]
    missing: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """The folder, as text to show."""
        return shown(self.path)

    @property
    def name(self) -> str:
        """Of the study or experiment."""
        return self.phases[0].experiment.name if self.study is None else self.study.name


def read(path: Path) -> Source:
    """Returns what a folder holds.

    Raises:
      RunError: it holds no run with a generation, or one that cannot be read.
    """
    if not study.is_study(path):
        return Source(path=path, study=None, phases=(_read_phase(path),))
    given = study_config.read(path)
    phases: list[Phase] = []
    missing: list[str] = []
    for number, (name, _) in enumerate(given.phases):
        place = given.folder(path, number)
        if (place / config.FILE).is_file() and metrics.read(place):
            study_config.check_phase(path, given, number)
            phases.append(_read_phase(place, is_between=not given.has_tournament(number)))
        else:
            missing.append(name)
    if not phases:
        raise RunError(f"{path} has no generation yet; evolve it: {shell.command('resume', path)}")
    return Source(path=path, study=given, phases=tuple(phases), missing=tuple(missing))


def by_variant(sources: Sequence[Source]) -> dict[str, tuple[Phase, ...]]:
    """Returns the runs of each phase over all sources, in the order of the longest study.

    Raises:
      RunError: their bodies or experiments differ, so that an average would mean nothing.
    """
    _check_bodies(sources)
    _check_families(sources)
    order = [p.name for s in sorted(sources, key=lambda s: -len(s.phases)) for p in s.phases]
    found: dict[str, tuple[Phase, ...]] = {}
    for name in dict.fromkeys(order):
        found[name] = tuple(p for s in sources for p in s.phases if p.name == name)
        for other in found[name][1:]:
            _check_same(found[name][0], other)
    return found


def shown(path: Path) -> str:
    """Returns a path as text, with escapes for what cannot be shown."""
    return terminal.one_line(str(path))


def _read_phase(path: Path, *, is_between: bool = False) -> Phase:
    run = runs.load(path)
    walker = walkers.best(path)
    study_name, _, phase = walker.experiment.name.rpartition("/")
    return Phase(
        name=phase,
        study=study_name or None,
        run=run,
        experiment=walker.experiment,
        walker=walker,
        tournament=tournament.read(path) if walker.rank == "winner" else None,
        is_running=folder.is_locked(path),
        is_between=is_between,
    )


def is_paper(variants: Mapping[str, Sequence[Phase]]) -> bool:
    """Returns whether any of the runs, by phase, has a body of Solomon, Locascio & Hartmann."""
    return any(phase.is_paper for phases in variants.values() for phase in phases)


def _check_bodies(sources: Sequence[Source]) -> None:
    first = sources[0].phases[0]
    for phase in (phase for source in sources for phase in source.phases):
        bodies = [each.body or type(each.experiment.env).__name__ for each in (first, phase)]
        if bodies[0] != bodies[1]:
            raise RunError(
                f"{first.label} walks with the body {bodies[0]} and {phase.label} with "
                f"{bodies[1]}; report on them apart"
            )


def _check_families(sources: Sequence[Source]) -> None:
    """Returns if all are phases of studies, or all of one experiment."""
    first = sources[0].phases[0]
    for phase in (phase for source in sources for phase in source.phases):
        names = [each.experiment.name for each in (first, phase)]
        if names[0] != names[1] and (first.study is None or phase.study is None):
            raise RunError(
                f"{first.label} is of the experiment {names[0]} and {phase.label} of {names[1]}, "
                "which cannot be averaged; report on them apart"
            )


def _check_same(first: Phase, other: Phase) -> None:
    """Returns if two runs obey the same settings, whatever study they are of."""
    one, two = (
        dict(_flat({**settings.to_data(each.experiment), "name": ""})) for each in (first, other)
    )
    for path in dict.fromkeys([*one, *two]):
        values = [each.get(path, "nothing") for each in (one, two)]
        if values[0] != values[1] and path.endswith("env.body"):
            raise RunError(
                f"{first.label} and {other.label} cannot be averaged: their bodies differ, though "
                f"both are called {first.body}; report on them apart"
            )
        if values[0] != values[1]:
            raise RunError(
                f"{first.label} and {other.label} cannot be averaged: {path} is {values[0]} in the "
                f"one and {values[1]} in the other; report on them apart"
            )


def _flat(data: Any, path: str = "") -> list[tuple[str, Any]]:
    if not isinstance(data, dict):
        return [(path, data)]
    items = [(f"{path}.{name}" if path else str(name), value) for name, value in data.items()]
    return [pair for inside, value in items for pair in _flat(value, inside)]
