"""All that is needed to repeat a run, as the file `config.json`."""

import dataclasses
from pathlib import Path
from typing import Any

import msgspec

from mjxwalk import settings
from mjxwalk.errors import RunError
from mjxwalk.runs import files, sealing

FILE = "config.json"
SCHEMA = 3  # of this file; raise it when a setting changes its meaning
# Older versions, which are read as well. The first had no digest; the files of a run that either
# began do not name their run (see `mjxwalk.runs.owner`).
UNSEALED = 1
UNNAMED = (UNSEALED, 2)

# ours: enough to fall back on when the newest is damaged. A run of thousands of generations that
# keeps all takes gigabytes, and the last 50 elites are in every checkpoint anyway.
KEEP = 20


# Settings that experiments did not have when older runs were written, and what they did then; a
# table that is not empty is of a group's settings.
ADDED: dict[str, Any] = {
    "start": "zero",
    "ramp": None,
    "arena": {},
    "pruning": None,
    "goal": {"fine_trials": 0, "fine_factor": 4},
    "env": {"min_speed": 0.0, "max_lag": 1e9, "body": ""},
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Origin:
    """Where what a run starts from was taken from; the run itself needs `start.npz` alone.

    Attributes:
      source: as it was named: a run's folder, or `zoo:NAME`.
      generation: of the walker or population.
    """

    source: str
    generation: int


@dataclasses.dataclass(frozen=True, kw_only=True)
class Config:
    """A run is a function of these on one machine.

    Attributes:
      experiment: a `mjxwalk.experiments.Experiment` or another frozen dataclass with a name; not
        imported here, since it brings JAX and reading a run does without.
      seed: of all random numbers.
      engine: as asked for, which may be "auto"; the manifest has what it came to.
      keep: newest checkpoints that stay; None keeps all.
      save_every: generations from one checkpoint to the next.
      origin: of what the run starts from; None for zero.
    """

    experiment: Any
    seed: int = 0
    engine: str = "auto"
    keep: int | None = KEEP
    save_every: int = 1
    origin: Origin | None = None

    def __post_init__(self) -> None:
        if not 0 <= self.seed < 2**32:
            raise ValueError(f"seed must be from 0 to {2**32 - 1}, got {self.seed}")
        for name in ("keep", "save_every"):
            value = getattr(self, name)
            if value is not None and not 1 <= value < 2**31:
                raise ValueError(f"{name} must be from 1 to {2**31 - 1}, got {value}")


class _File(msgspec.Struct, kw_only=True, forbid_unknown_fields=True):
    schema: int
    digest: str | None = None
    seed: int
    engine: str
    keep: int | None
    save_every: int
    origin: Origin | None = None
    start: str | None = None
    experiment: dict[str, Any]


def write(folder: Path, config: Config, start: str | None = None) -> None:
    """Writes `config.json`.

    Args:
      folder: of the run.
      config: its settings.
      start: digest of its `start.npz`, None where it has none.

    Raises:
      RunError: the settings would not read back as they are.
    """
    try:
        content = text(config, start)
    except UnicodeEncodeError:
        raise RunError(
            f"experiment {config.experiment.name} has a setting that is no text"
        ) from None
    if len(content) > files.MOST_JSON:
        raise RunError(f"the settings take {len(content)} bytes, more than {files.MOST_JSON}")
    if not _reads_back(content, config):
        raise RunError(
            f"experiment {config.experiment.name} has a setting that JSON cannot hold, so the run "
            "could not be repeated; use finite numbers, texts, lists and tables"
        )
    files.replace(folder, FILE, content)


def text(config: Config, start: str | None = None) -> bytes:
    """Returns the content of `config.json`; the arguments are those of `write`."""
    return sealing.sealed(_to_file(config, start))


def read_data(folder: Path) -> dict[str, Any]:
    """Returns `config.json` as plain data, its outer layer checked.

    Raises:
      RunError: the folder holds no run, or the file is not what a run writes.
    """
    file, content = _read_file(folder)
    _check(folder / FILE, file, content)
    data = msgspec.to_builtins(file)
    del data[sealing.DIGEST], data["start"]
    return data


def start_digest(folder: Path) -> str | None:
    """Returns the digest that a run's `start.npz` must have; older versions noted none.

    Raises:
      RunError: the folder holds no run, or the file is not what a run writes.
    """
    return _read_file(folder)[0].start


def read(folder: Path) -> Config:
    """Returns the settings of a run; they equal those that were written.

    Raises:
      RunError: the folder holds no run, or a setting is unknown, missing or of a wrong type.
    """
    file, content = _read_file(folder)
    try:
        config = _from_file(file, None)
    except (RunError, ValueError) as error:
        raise RunError(f"{folder / FILE}: {error}") from None
    # Last: what is wrong with a setting says more.
    _check(folder / FILE, file, content)
    return config


def _check(path: Path, file: _File, content: bytes) -> None:
    if file.schema != UNSEALED or file.digest is not None:
        sealing.check(path, content, needed=True)


def _read_file(folder: Path) -> tuple[_File, bytes]:
    path = folder / FILE
    raw = files.read_inside(folder, FILE, files.MOST_JSON)
    if raw is None:
        raise RunError(f"{folder} is no run: it has no {FILE}")
    schema = files.decode_table(path, raw).get("schema")
    if isinstance(schema, int) and schema not in (*UNNAMED, SCHEMA):
        raise RunError(f"{path} has version {schema} and this mjxwalk reads version {SCHEMA}")
    return files.decode(path, raw, _File), raw


def _reads_back(content: bytes, config: Config) -> bool:
    try:
        return _from_file(msgspec.json.decode(content, type=_File), config.experiment) == config
    except RunError:
        return False


def _to_file(config: Config, start: str | None) -> _File:
    return _File(
        schema=SCHEMA,
        seed=config.seed,
        engine=config.engine,
        keep=config.keep,
        save_every=config.save_every,
        origin=config.origin,
        start=start,
        experiment=settings.to_data(config.experiment),
    )


def experiment_of(data: dict[str, Any], defaults: Any = None) -> Any:
    """Returns an experiment from its settings as plain data; imports JAX.

    Settings that experiments did not have when older runs were written are filled in.

    Args:
      data: the settings.
      defaults: an experiment of the same classes; None for the one of that name.

    Raises:
      RunError: a setting is unknown, missing or of a wrong type.
      ValueError: there is no experiment of that name.
    """
    if defaults is None:
        from mjxwalk import experiments  # imports JAX, which most of this package does without

        defaults = experiments.get(str(data.get("name")))
    data = _with_added(data, ADDED, defaults)
    return settings.from_data(defaults, data, "experiment")


def _with_added(data: dict[str, Any], added: dict[str, Any], defaults: Any) -> dict[str, Any]:
    filled = dict(data)
    for name, value in added.items():
        if isinstance(value, dict) and value:
            if isinstance(data.get(name), dict):
                filled[name] = _with_added(data[name], value, getattr(defaults, name, None))
        elif dataclasses.is_dataclass(defaults) and name in _field_names(defaults):
            filled.setdefault(name, value)
    return filled


def _field_names(settings: Any) -> set[str]:
    return {field.name for field in dataclasses.fields(settings)}


def _from_file(file: _File, defaults: Any) -> Config:
    return Config(
        experiment=experiment_of(file.experiment, defaults),
        seed=file.seed,
        engine=file.engine,
        keep=file.keep,
        save_every=file.save_every,
        origin=file.origin,
    )
