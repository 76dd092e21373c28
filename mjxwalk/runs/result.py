"""What a finished run came to, as the files `result.json` and `champion.npz`."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy.typing as npt

from mjxwalk.errors import RunError
from mjxwalk.runs import digests, files, owner
from mjxwalk.runs.npz import MOST_BYTES, from_npz, npz

FILE = "result.json"
CHAMPION_FILE = "champion.npz"


class Champion(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The best walker of a run, on terrains that played no part in choosing it.

    Attributes:
      generation: in which it was the fittest.
      distance_m: mean over the terrains.
      fall_rate: share of the trials that ended by a fall.
      speed_m_s: distance over duration of all trials; None if it had no duration.
      cost_of_transport: work over weight times distance; None if it did not get anywhere.
      terrains: number of them; 0 of what was fitted and walks nowhere.
      figures: of what was fitted, by name.
      fitness: mean over the terrains; None in older runs and of what was fitted.
    """

    generation: int
    distance_m: float
    fall_rate: float
    speed_m_s: float | None
    cost_of_transport: float | None
    terrains: int
    figures: dict[str, float] = {}
    fitness: float | None = None


class Result(msgspec.Struct, frozen=True, kw_only=True):
    """What a run came to.

    Attributes:
      champion: the best walker.
      generations: evaluated.
      wall_s: wall time of all generations, over every resume.
      physics_steps: in all generations.
    """

    champion: Champion
    generations: int
    wall_s: float
    physics_steps: int


class _File(Result, frozen=True, kw_only=True, forbid_unknown_fields=True):
    digest: str | None = None
    run: str | None = None
    weights: str | None = None  # digest of the champion's file


def write(folder: Path, result: Result, genotype: Mapping[str, npt.NDArray[Any]]) -> None:
    """Writes the champion's weights by name, then the result: with it the run is finished.

    Raises:
      RunError: the files cannot be written, for example because the disk is full.
    """
    weights = npz(genotype)
    files.replace(folder, CHAMPION_FILE, weights)
    told = {**msgspec.to_builtins(result), "weights": digests.of_bytes(weights)}
    files.replace(folder, FILE, owner.with_digest(folder, told))


def read(folder: Path) -> Result | None:
    """Returns the result of a finished run, None of one that is not.

    Raises:
      RunError: the file is not what a run writes, was changed, or is of another run.
    """
    file = _read(folder)
    if file is None:
        return None
    return Result(
        champion=file.champion,
        generations=file.generations,
        wall_s=file.wall_s,
        physics_steps=file.physics_steps,
    )


def read_genotype(folder: Path) -> dict[str, npt.NDArray[Any]]:
    """Returns the champion's weights by name.

    Raises:
      RunError: there is none, or the file is damaged or that of another result.
    """
    content = files.read_inside(folder, CHAMPION_FILE, MOST_BYTES)
    if content is None:
        raise RunError(f"{folder} has no champion yet: the run is not finished")
    file = _read(folder)
    if file is not None and file.weights is not None:
        owner.check_content(folder / CHAMPION_FILE, content, file.weights)
    return from_npz(folder / CHAMPION_FILE, content)


def _read(folder: Path) -> _File | None:
    content = owner.read(folder, FILE)
    return None if content is None else files.decode(folder / FILE, content, _File)
