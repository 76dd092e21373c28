"""All that is needed to repeat a study: its phases' experiments, and what their runs share."""

import dataclasses
import re
from pathlib import Path
from typing import Any

import msgspec

from mjxwalk import settings
from mjxwalk.errors import RunError
from mjxwalk.experiments import run_config, stored
from mjxwalk.experiments.run_config import Config
from mjxwalk.experiments.scaling import LARGEST
from mjxwalk.runs import config, study
from mjxwalk.runs.study import PhaseFile, StudyFile


@dataclasses.dataclass(frozen=True, kw_only=True)
class StudyConfig:
    """All that is needed to repeat a study.

    Attributes:
      name: of the study.
      phases: name and experiment of each, first to last.
      seed: of each phase, as in `Config`, as are the next three settings.
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


def create(path: Path, made: StudyConfig) -> None:
    """Makes a study's folder with its `study.json`.

    Raises:
      RunError: the folder is taken, cannot be made, or the settings would not read back.
    """
    study.check_free(path)
    file = StudyFile(
        schema=study.SCHEMA,
        name=made.name,
        seed=made.seed,
        engine=made.engine,
        keep=made.keep,
        save_every=made.save_every,
        scale=made.scale,
        phases=[
            PhaseFile(name=name, experiment=settings.to_data(experiment))
            for name, experiment in made.phases
        ],
    )
    if _from_file(msgspec.json.decode(study.text(file), type=StudyFile)) != made:
        raise RunError(f"study {made.name} has a setting that JSON cannot hold")
    study.create(path, file)


def read(path: Path) -> StudyConfig:
    """Returns the settings of a study; they equal those that were written.

    Raises:
      RunError: the folder holds none, or a setting is unknown, missing or of a wrong type.
    """
    file, content = study.read(path)
    try:
        made = _from_file(file)
    except (RunError, ValueError) as error:
        raise RunError(f"{path / study.FILE}: {error}") from None
    study.check(path, file, content)  # last: what is wrong with a setting says more
    return made


def check_phase(path: Path, made: StudyConfig, number: int) -> None:
    """Raises RunError unless the run of a phase that was begun is this study's.

    Args:
      path: of the study's folder.
      made: its settings.
      number: of the phase, from 0.
    """
    place = made.folder(path, number)
    # Where a phase starts from is known when the phase before has ended.
    if dataclasses.replace(run_config.read(place), origin=None) != made.run(number):
        raise RunError(
            f"{place} is a run of another study than {path / study.FILE}; put back its own"
        )


def _from_file(file: StudyFile) -> StudyConfig:
    return StudyConfig(
        name=file.name,
        phases=tuple((p.name, stored.from_data(p.experiment)) for p in file.phases),
        seed=file.seed,
        engine=file.engine,
        keep=file.keep,
        save_every=file.save_every,
        scale=file.scale,
    )
