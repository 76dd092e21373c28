"""What a finished run came to, as the files `result.json` and `champion.npz`."""

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from mjxwalk.errors import RunError
from mjxwalk.runs import files

FILE = "result.json"
CHAMPION_FILE = "champion.npz"


class Champion(msgspec.Struct, frozen=True, kw_only=True):
    """The best walker of a run, on terrains that played no part in choosing it.

    Attributes:
      generation: in which it was the fittest.
      distance_m: mean over the terrains.
      fall_rate: share of the trials that ended by a fall.
      speed_m_s: distance over duration of all trials; None if it had no duration.
      cost_of_transport: work over weight times distance; None if it did not get anywhere.
      terrains: number of them; 0 of what was fitted and walks nowhere.
      figures: of what was fitted, by name.
    """

    generation: int
    distance_m: float
    fall_rate: float
    speed_m_s: float | None
    cost_of_transport: float | None
    terrains: int
    figures: dict[str, float] = {}


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


def write(folder: Path, result: Result, genotype: Mapping[str, npt.NDArray[Any]]) -> None:
    """Writes the champion's weights by name, then the result: with it the run is finished.

    Raises:
      RunError: the files cannot be written, for example because the disk is full.
    """
    files.replace(folder / CHAMPION_FILE, npz(genotype))
    text = msgspec.json.format(msgspec.json.encode(result), indent=2)
    files.replace(folder / FILE, text + b"\n")


def npz(arrays: Mapping[str, npt.NDArray[Any]]) -> bytes:
    """Returns the content of an npz file that is the same for the same arrays.

    `numpy.savez` writes the time of day into it, and refuses an array named "file".
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, array in arrays.items():
            with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w") as file:
                np.lib.format.write_array(file, np.asarray(array), allow_pickle=False)
    return buffer.getvalue()


def read(folder: Path) -> Result | None:
    """Returns the result of a finished run, None of one that is not.

    Raises:
      RunError: the file is not what a run writes.
    """
    return files.read_json(folder / FILE, Result)


def read_genotype(folder: Path) -> dict[str, npt.NDArray[Any]]:
    """Returns the champion's weights by name.

    Raises:
      RunError: there is none, or the file is damaged.
    """
    path = folder / CHAMPION_FILE
    if not path.exists():
        raise RunError(f"{folder} has no champion yet: the run is not finished")
    return read_npz(path)


def read_npz(path: Path) -> dict[str, npt.NDArray[Any]]:
    """Returns the arrays of an npz file by name.

    Raises:
      RunError: it is damaged.
    """
    try:
        with np.load(io.BytesIO(files.read(path)), allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except Exception as error:  # zipfile, zlib and numpy each raise their own on damaged bytes
        raise RunError(f"{path} is damaged ({error})") from None
