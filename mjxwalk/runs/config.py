"""All that is needed to repeat a run, as plain data in the file `config.json`."""

import dataclasses
from pathlib import Path
from typing import Any

import msgspec

from mjxwalk.errors import RunError
from mjxwalk.runs import digests, files

FILE = "config.json"
SCHEMA = 3  # of this file; raise it when a setting changes its meaning
# Older versions, which are read as well. The first had no digest; the files of a run that either
# began do not name their run (see `mjxwalk.runs.owner`).
WITHOUT_DIGEST = 1
UNNAMED = (WITHOUT_DIGEST, 2)

# ours: enough to fall back on when the newest is damaged. A run of thousands of generations that
# keeps all takes gigabytes, and the last 50 elites are in every checkpoint anyway.
KEEP = 20


@dataclasses.dataclass(frozen=True, kw_only=True)
class Origin:
    """Where what a run starts from was taken from; the run itself needs `start.npz` alone.

    Attributes:
      source: as it was named: a run's folder, or `zoo:NAME`.
      generation: of the walker or population.
    """

    source: str
    generation: int


class Code(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The code of a user's own task, which is in the run's folder.

    Attributes:
      file: what the user's file was called.
      name: of the experiment in it; "" for the only one.
      sha256: of the text.
    """

    file: str
    name: str
    sha256: str


class ConfigFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The content of `config.json`.

    Attributes:
      schema: version of the file.
      digest: of all else; the first version had none.
      seed: of all random numbers.
      engine: as asked for, which may be "auto"; the manifest has what it came to.
      keep: newest checkpoints that stay; None keeps all.
      save_every: generations from one checkpoint to the next.
      origin: of what the run starts from; None for zero.
      start: digest of `start.npz`; None where there is none, and of older versions.
      code: of a user's own task; unset of our own experiments.
      experiment: its settings.
    """

    schema: int
    digest: str | None = None
    seed: int
    engine: str
    keep: int | None
    save_every: int
    origin: Origin | None = None
    start: str | None = None
    code: Code | msgspec.UnsetType = msgspec.UNSET
    experiment: dict[str, Any]

    @property
    def own_code(self) -> Code | None:
        """The code of a user's own task, None of our own experiments."""
        return None if isinstance(self.code, msgspec.UnsetType) else self.code


def write(folder: Path, file: ConfigFile) -> None:
    """Writes `config.json`.

    Raises:
      RunError: a setting is no text, or all of them are too long.
    """
    content = text(file)
    if len(content) > files.MOST_JSON:
        raise RunError(f"the settings take {len(content)} bytes, more than {files.MOST_JSON}")
    files.replace(folder, FILE, content)


def text(file: ConfigFile) -> bytes:
    """Returns the content of `config.json`, with its digest.

    Raises:
      RunError: a setting is no text.
    """
    try:
        return digests.with_digest(file)
    except UnicodeEncodeError:
        raise RunError(
            f"experiment {file.experiment.get('name')} has a setting that is no text"
        ) from None


def read_data(folder: Path) -> dict[str, Any]:
    """Returns `config.json` as plain data, its outer layer checked.

    Raises:
      RunError: the folder holds no run, or the file is not what a run writes.
    """
    file, content = read(folder)
    check(folder, file, content)
    data = msgspec.to_builtins(file)
    del data[digests.DIGEST], data["start"]
    return data


def start_digest(folder: Path) -> str | None:
    """Returns the digest that a run's `start.npz` must have; older versions noted none.

    Raises:
      RunError: the folder holds no run, or the file is not what a run writes.
    """
    return read(folder)[0].start


def read(folder: Path) -> tuple[ConfigFile, bytes]:
    """Returns `config.json` as it was found, which `check` must follow, and its bytes.

    Raises:
      RunError: the folder holds no run, or the file is not what a run writes.
    """
    path = folder / FILE
    raw = files.read_inside(folder, FILE, files.MOST_JSON)
    if raw is None:
        raise RunError(f"{folder} is no run: it has no {FILE}")
    schema = files.decode_table(path, raw).get("schema")
    if isinstance(schema, int) and schema not in (*UNNAMED, SCHEMA):
        raise RunError(f"{path} has version {schema} and this mjxwalk reads version {SCHEMA}")
    return files.decode(path, raw, ConfigFile), raw


def check(folder: Path, file: ConfigFile, content: bytes) -> None:
    """Raises RunError unless `config.json` is as it was written."""
    if file.schema != WITHOUT_DIGEST or file.digest is not None:
        digests.check(folder / FILE, content, needed=True)
