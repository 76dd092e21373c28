"""All that is needed to repeat a run: an experiment, a seed, and how it is run and kept."""

import dataclasses
from pathlib import Path
from typing import Any

import msgspec

from mjxwalk import settings
from mjxwalk.errors import RunError, first_line
from mjxwalk.experiments import own_task, stored
from mjxwalk.runs import config, folder
from mjxwalk.runs.config import Code, ConfigFile, Origin
from mjxwalk.runs.inheritance import Inherited


@dataclasses.dataclass(frozen=True, kw_only=True)
class Config:
    """A run is a function of these on one machine.

    Attributes:
      experiment: an `Experiment`, or another frozen dataclass with a name.
      seed: of all random numbers.
      engine: as asked for, which may be "auto"; the manifest has what it came to.
      keep: newest checkpoints that stay; None keeps all.
      save_every: generations from one checkpoint to the next.
      origin: of what the run starts from; None for zero.
      code: of a user's own task; None of our own experiments.
    """

    experiment: Any
    seed: int = 0
    engine: str = "auto"
    keep: int | None = config.KEEP
    save_every: int = 1
    origin: Origin | None = None
    code: Code | None = None

    def __post_init__(self) -> None:
        if not 0 <= self.seed < 2**32:
            raise ValueError(f"seed must be from 0 to {2**32 - 1}, got {self.seed}")
        for name in ("keep", "save_every"):
            value = getattr(self, name)
            if value is not None and not 1 <= value < 2**31:
                raise ValueError(f"{name} must be from 1 to {2**31 - 1}, got {value}")


def create(
    path: Path,
    settings: Config,
    inherited: Inherited | None = None,
    task: bytes | None = None,
) -> None:
    """Makes a run's folder with its `config.json`.

    Args:
      path: of the folder.
      settings: of the run.
      inherited: what it starts from; None for zero.
      task: text of a user's own task; None of our own experiments.

    Raises:
      RunError: the folder is taken, cannot be made, or the settings would not read back.
    """
    folder.create(path, to_file(settings), inherited, task)


def read(path: Path) -> Config:
    """Returns the settings of the run in a folder; they equal those that were written.

    Raises:
      RunError: the folder holds no run, a setting is unknown, missing or of a wrong type, or the
        run has code that this user does not trust.
    """
    file, content = config.read(path)
    task = None
    if file.own_code is not None:
        config.check(path, file, content)
        task = own_task.of_run(path, file.own_code, is_main=True)
    try:
        name = str(file.experiment.get("name"))
        made = _from_file(file, None if task is None else task.named(name))
    except (RunError, ValueError) as error:
        raise RunError(f"{path / config.FILE}: {error}") from None
    config.check(path, file, content)  # last: what is wrong with a setting says more
    return made


def to_file(made: Config) -> ConfigFile:
    """Returns the content of `config.json`.

    Raises:
      RunError: the settings would not read back as they are.
    """
    try:
        plain = settings.to_data(made.experiment)
    except (TypeError, ValueError, RecursionError) as error:
        raise _unkept(made, error) from None
    file = ConfigFile(
        schema=config.SCHEMA,
        seed=made.seed,
        engine=made.engine,
        keep=made.keep,
        save_every=made.save_every,
        origin=made.origin,
        code=msgspec.UNSET if made.code is None else made.code,
        experiment=plain,
    )
    if not _reads_back(file, made):
        raise _unkept(made)
    return file


def _unkept(made: Config, error: Exception | None = None) -> RunError:
    why = "" if error is None else f" ({first_line(error)})"
    return RunError(
        f"experiment {made.experiment.name} has a setting that JSON cannot hold{why}, so the run "
        "could not be repeated; use finite numbers, texts, lists and tables"
    )


def text(made: Config) -> bytes:
    """Returns the settings as the content of a file.

    Raises:
      RunError: they would not read back as they are.
    """
    return config.text(to_file(made))


def _reads_back(file: ConfigFile, made: Config) -> bool:
    try:
        content = msgspec.json.decode(config.text(file), type=ConfigFile)
        return _from_file(content, made.experiment) == made
    except RunError:
        return False


def _from_file(file: ConfigFile, defaults: Any) -> Config:
    return Config(
        experiment=stored.from_data(file.experiment, defaults),
        seed=file.seed,
        engine=file.engine,
        keep=file.keep,
        save_every=file.save_every,
        origin=file.origin,
        code=file.own_code,
    )
