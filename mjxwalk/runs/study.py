"""A study on disk: a folder with `study.json` and one run's folder for each phase."""

import dataclasses
import re
from pathlib import Path
from typing import Any

import msgspec

from mjxwalk import settings, shell
from mjxwalk.errors import RunError
from mjxwalk.experiments.scaling import LARGEST
from mjxwalk.runs import config, files, sealing
from mjxwalk.runs.config import Config
from mjxwalk.runs.locking import LOCK_FILE, locked

FILE = "study.json"
SCHEMA = 2  # of this file; raise it when a setting changes its meaning
UNSEALED = 1  # the version before, which had no digest and is read as well
# What a process that was killed while it made a study's folder may have left in it.
BEGUN = (LOCK_FILE, files.partial(FILE))


@dataclasses.dataclass(frozen=True, kw_only=True)
class StudyConfig:
    """All that is needed to repeat a study.

    Attributes:
      name: of the study.
      phases: name and experiment of each, first to last.
      seed: of each phase, as in `Config`; likewise the next three.
      engine: as asked for.
      keep: newest checkpoints that stay of each phase.
      save_every: generations from one checkpoint to the next.
      scale: that the phases were scaled by; here it stands for the tournaments only.
    """

    name: str
    phases: tuple[tuple[str, Any], ...]
    seed: int = 0
    engine: str = "auto"
    keep: int | None = config.KEEP
    save_every: int = 1
    scale: float = 1.0

    def __post_init__(self) -> None:
        if not self.phases:
            raise ValueError("phases must be one at least, got none")
        for name, _ in self.phases:
            # A folder is called like it.
            if not re.fullmatch(r"[A-Za-z0-9_-]{1,100}", name):
                raise ValueError(f"phases must be named by letters, digits and -, got {name!r}")
        if not 0 < self.scale <= LARGEST:
            raise ValueError(f"scale must be above 0 and at most {LARGEST:g}, got {self.scale}")
        self.run(0)  # checks seed, keep and save_every

    def run(self, number: int) -> Config:
        """Returns the settings of a phase's run; phases are counted from 0."""
        return Config(
            experiment=self.phases[number][1],
            seed=self.seed,
            engine=self.engine,
            keep=self.keep,
            save_every=self.save_every,
        )

    def has_tournament(self, number: int) -> bool:
        """Returns whether a phase ends with a tournament.

        None decides a phase whose goal does, or one whose population is only averaged by the next.
        """
        following = self.phases[number + 1 :]
        averaged = bool(following) and following[0][1].start == "mean"
        return not averaged and self.phases[number][1].goal.trials == 0

    def folder(self, path: Path, number: int) -> Path:
        """Returns where a phase's run is in the study's folder; phases are counted from 0."""
        return path / f"{number + 1}-{self.phases[number][0]}"


class _Phase(msgspec.Struct, kw_only=True, forbid_unknown_fields=True):
    name: str
    experiment: dict[str, Any]


class _File(msgspec.Struct, kw_only=True, forbid_unknown_fields=True):
    schema: int
    digest: str | None = None
    name: str
    seed: int
    engine: str
    keep: int | None
    save_every: int
    scale: float
    phases: list[_Phase]


def is_study(path: Path) -> bool:
    """Returns whether a folder holds a study."""
    return (path / FILE).is_file()


def check_free(path: Path) -> None:
    """Returns if a study may start in a folder.

    Raises:
      RunError: it holds anything, or is no folder.
    """
    if is_study(path):
        raise RunError(
            f"{path} already holds a study; continue it with `{shell.command('resume', path)}` or "
            "choose another --out"
        )
    if path.exists() and (
        not path.is_dir() or any(each.name not in BEGUN for each in path.iterdir())
    ):
        raise RunError(f"{path} exists and is not an empty folder; choose another --out")


def create(path: Path, study: StudyConfig) -> None:
    """Makes a study's folder with its `study.json`.

    Raises:
      RunError: the folder is taken, cannot be made, or the settings would not read back.
    """
    check_free(path)
    text = sealing.sealed(
        _File(
            schema=SCHEMA,
            name=study.name,
            seed=study.seed,
            engine=study.engine,
            keep=study.keep,
            save_every=study.save_every,
            scale=study.scale,
            phases=[
                _Phase(name=name, experiment=settings.to_data(experiment))
                for name, experiment in study.phases
            ],
        )
    )
    if _from_file(msgspec.json.decode(text, type=_File)) != study:
        raise RunError(f"study {study.name} has a setting that JSON cannot hold")
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{path} could not be made: {files.describe(error)}") from error
    with locked(path):
        check_free(path)  # again: another process may have been as quick
        files.replace(path, FILE, text)


def read(path: Path) -> StudyConfig:
    """Returns the settings of a study; they equal those that were written.

    Raises:
      RunError: the folder holds none, or a setting is unknown, missing or of a wrong type.
    """
    file = path / FILE
    raw = files.read_inside(path, FILE, files.MOST_JSON)
    if raw is None:
        raise RunError(f"{path} is no study: it has no {FILE}")
    schema = files.decode_table(file, raw).get("schema")
    if isinstance(schema, int) and schema not in (UNSEALED, SCHEMA):
        raise RunError(f"{file} has version {schema} and this mjxwalk reads version {SCHEMA}")
    data = files.decode(file, raw, _File)
    try:
        study = _from_file(data)
    except (RunError, ValueError) as error:
        raise RunError(f"{file}: {error}") from None
    if data.schema != UNSEALED or data.digest is not None:
        sealing.check(file, raw, needed=True)  # last: what is wrong with a setting says more
    return study


def check_phase(path: Path, study: StudyConfig, number: int) -> None:
    """Raises RunError unless the run of a phase that was begun is this study's.

    Args:
      path: of the study's folder.
      study: its settings.
      number: of the phase, from 0.
    """
    place = study.folder(path, number)
    # Where a phase starts from is known when the phase before has ended.
    if dataclasses.replace(config.read(place), origin=None) != study.run(number):
        raise RunError(f"{place} is a run of another study than {path / FILE}; put back its own")


def _from_file(file: _File) -> StudyConfig:
    return StudyConfig(
        name=file.name,
        phases=tuple((p.name, config.experiment_of(p.experiment)) for p in file.phases),
        seed=file.seed,
        engine=file.engine,
        keep=file.keep,
        save_every=file.save_every,
        scale=file.scale,
    )
