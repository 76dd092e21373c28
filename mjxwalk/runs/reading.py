"""Reads a run, finished or not, into numpy arrays, without an accelerator."""

import dataclasses
import operator
from pathlib import Path
from typing import Any

import numpy.typing as npt

from mjxwalk.errors import RunError
from mjxwalk.runs import config, folder, manifest, metrics, result
from mjxwalk.runs.config import Code
from mjxwalk.runs.result import Result

Arrays = dict[str, npt.NDArray[Any]]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Run:
    """What is on disk of a run.

    Names of arrays join the names of nested fields by dots. The genotypes of `population` and
    `champion` are dicts of their leaves; `unflatten` turns one into the experiment's own type.

    Attributes:
      path: of its folder.
      config: `config.json` as plain data; `experiments.of_run` makes the experiment of it.
      manifest: `manifest.json`, {} if it was never written.
      metrics: each figure as an array over generations, NaN where it has no value.
      generations: that have a checkpoint.
      generation: of the checkpoint that was read, 0 if there is none.
      damaged: newer checkpoints that were passed over, each with the reason.
      arrays: everything in the checkpoint, by name.
      result: of a finished run, else None.
      champion: the champion's weights by leaf; {} of a run that is not finished.
    """

    path: Path
    config: dict[str, Any]
    manifest: dict[str, Any]
    metrics: Arrays
    generations: list[int]
    generation: int
    damaged: dict[int, str]
    arrays: Arrays
    result: Result | None
    champion: Arrays

    @property
    def code(self) -> Code | None:
        """The code of a user's own task, None of our own experiments."""
        found = self.config.get("code")
        return None if found is None else Code(**found)

    @property
    def population(self) -> Arrays:
        """The genotypes evaluated last, by leaf [pop, ...]."""
        return self.part("population")

    @property
    def fitness(self) -> npt.NDArray[Any]:
        """Their fitness [pop], a mean over the generation's terrains."""
        return self._array("fitness")

    @property
    def outcome(self) -> Arrays:
        """What else they did, by the names of `mjxwalk.rollout.Outcome` [pop], likewise means."""
        return self.part("outcome")

    @property
    def elite(self) -> Arrays:
        """The fittest of them, by leaf."""
        return self.part("elite")

    @property
    def elites(self) -> Arrays:
        """The fittest of each of the last generations, by leaf [elite, ...], newest last."""
        return self.part("elites.genotypes")

    @property
    def strategy_state(self) -> Arrays:
        """The strategy's own state, masks included, by name."""
        return self.part("strategy")

    def part(self, prefix: str) -> Arrays:
        """Returns the checkpoint's arrays whose names start with `prefix` and a dot, without it.

        A part that is one array is named "value", as in `trees.flatten`.
        """
        if prefix in self.arrays:
            return {"value": self.arrays[prefix]}
        start = prefix + "."
        return {k.removeprefix(start): v for k, v in self.arrays.items() if k.startswith(start)}

    def _array(self, name: str) -> npt.NDArray[Any]:
        if name not in self.arrays:
            raise RunError(f"{self.path} has no checkpoint to read {name} from")
        return self.arrays[name]


def load(path: str | Path, generation: int | None = None) -> Run:
    """Returns a run as it is on disk.

    Args:
      path: the run's folder.
      generation: whose checkpoint to read; None for the newest that is whole, if there is any.

    Raises:
      RunError: the folder holds no run, or the generation asked for cannot be read.
    """
    path = Path(path)
    if generation is not None:
        try:
            generation = operator.index(generation)
        except TypeError:
            raise RunError(f"generation must be a whole number, got {generation!r}") from None
    folder.check_run(path)
    data = config.read_data(path)
    generations, number, arrays, damaged = _checkpoint(path / folder.CHECKPOINTS, generation)
    finished = result.read(path)
    return Run(
        path=path,
        config=data,
        manifest=manifest.read(path),
        metrics=metrics.columns(metrics.read(path)),
        generations=generations,
        generation=number,
        damaged=damaged,
        arrays=arrays,
        result=finished,
        champion=result.read_genotype(path) if finished else {},
    )


def _checkpoint(
    path: Path, generation: int | None
) -> tuple[list[int], int, Arrays, dict[int, str]]:
    from mjxwalk.runs import checkpoints  # imports Orbax, and with it JAX

    if generation is not None:
        arrays = checkpoints.restore(path, generation)
        return checkpoints.generations(path), generation, arrays, {}
    number, arrays, damaged = checkpoints.restore_newest(path)
    return checkpoints.generations(path), number, arrays, damaged
