"""One walker of the zoo on disk: its weights as NAME.npz, where it comes from as NAME.json."""

from pathlib import Path
from typing import Any

import msgspec
import numpy.typing as npt

from mjxwalk import experiments, outputs
from mjxwalk.errors import RunError
from mjxwalk.outputs import as_json
from mjxwalk.runs import files
from mjxwalk.runs.npz import npz, read_npz
from mjxwalk.tournament.results import Tournament
from mjxwalk.walker import Walker

PREFIX = "zoo:"  # of a source that is an entry, and no folder
SCHEMA = 1  # of the JSON file; raise it when a field changes its meaning


class Provenance(msgspec.Struct, frozen=True, kw_only=True):
    """Where a walker comes from, and what it can do.

    Attributes:
      schema: of the file.
      experiment: settings of the run, as plain data.
      seed: of the run.
      generation: in which it was the fittest.
      engine: that ran the evolution.
      mjxwalk: version that it evolved with.
      commit: of the checkout that it evolved with, None where there was none.
      command: that made it.
      tournament: that it won.
    """

    schema: int
    experiment: dict[str, Any]
    seed: int
    generation: int
    engine: str
    mjxwalk: str
    commit: str | None
    command: str
    tournament: Tournament


def write(
    folder: Path, name: str, provenance: Provenance, arrays: dict[str, npt.NDArray[Any]]
) -> None:
    """Writes an entry of the zoo; an old one of the name is replaced.

    Raises:
      RunError: a file cannot be written.
    """
    outputs.write(folder / f"{name}.npz", npz(arrays))
    outputs.write(folder / f"{name}.json", as_json(provenance))


def read(folder: Path, name: str) -> Provenance:
    """Returns where a walker comes from.

    Raises:
      RunError: the file cannot be read, or is of another version.
    """
    path = folder / f"{name}.json"
    provenance = files.decode(path, files.read(path, files.MOST_JSON), Provenance)
    if provenance.schema != SCHEMA:
        raise RunError(
            f"{path} has version {provenance.schema} and this mjxwalk reads version {SCHEMA}"
        )
    return provenance


def read_walker(folder: Path, name: str) -> Walker:
    """Returns a walker; imports JAX.

    Raises:
      RunError: a file is damaged, or the weights do not fit the experiment.
    """
    from mjxwalk.runs import unflatten

    provenance = read(folder, name)
    path = folder / f"{name}.json"
    try:
        experiment = experiments.from_data(provenance.experiment)
    except (RunError, ValueError) as error:
        raise RunError(f"{path}: {error}") from None
    arrays = read_npz(folder / f"{name}.npz")
    try:
        genotype = unflatten(experiment.template(), arrays)
    except RunError as error:
        raise RunError(f"{folder / name}.npz does not fit its experiment: {error}") from None
    return Walker(
        name=f"{PREFIX}{name}",
        rank="winner",
        experiment=experiment,
        genotype=genotype,
        generation=provenance.generation,
    )
