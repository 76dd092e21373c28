"""What a run starts from, where that is not zero, as the file `start.npz` in its folder."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from mjxwalk.errors import RunError
from mjxwalk.runs import config, digests, files, owner
from mjxwalk.runs.npz import MOST_BYTES, from_npz, npz

FILE = "start.npz"
PARTS = ("genotype", "strategy", "sensed")  # that are arrays by name

Arrays = dict[str, npt.NDArray[Any]]


class Inherited(NamedTuple):
    """A walker, or a whole population and what goes with it; arrays by name.

    Attributes:
      genotype: of the walker that generation 0 is drawn around; {} for a population.
      strategy: state of the strategy that goes on; {} for a walker.
      elite_fitness: of the last generations that the population has behind it, newest last.
      sensed: what the population's run has sensed, in double precision; {} for a walker, which
        carries it, and of a controller that does not normalise its senses.
    """

    genotype: Arrays
    strategy: Arrays
    elite_fitness: npt.NDArray[Any]
    sensed: Arrays = {}


def write(folder: Path, inherited: Inherited) -> str:
    """Writes `start.npz`, and returns its digest.

    Raises:
      RunError: it cannot be written, for example because the disk is full.
    """
    arrays: Arrays = {}
    for part in PARTS:
        values: Arrays = getattr(inherited, part)
        arrays |= {f"{part}.{name}": array for name, array in values.items()}
    arrays["elite_fitness"] = inherited.elite_fitness
    content = npz(arrays)
    files.replace(folder, FILE, content)
    return digests.of_bytes(content)


def read(folder: Path) -> Inherited:
    """Returns what the run in a folder starts from, the same bits that were written.

    Raises:
      RunError: the file is missing or damaged, or another than the run began with.
    """
    path, content = folder / FILE, files.read_inside(folder, FILE, MOST_BYTES)
    if content is None:
        raise RunError(f"{folder} lacks {FILE}, which its run starts from")
    expected = config.start_digest(folder)
    if expected is not None:
        owner.check_content(path, content, expected)
    arrays = from_npz(path, content)
    if "elite_fitness" not in arrays:
        raise RunError(f"{path} is damaged (it has no elite_fitness)")

    def part(name: str) -> Arrays:
        prefix = f"{name}."
        named = {each: array for each, array in arrays.items() if each.startswith(prefix)}
        return {each.removeprefix(prefix): array for each, array in named.items()}

    return Inherited(
        elite_fitness=np.asarray(arrays["elite_fitness"]), **{name: part(name) for name in PARTS}
    )
