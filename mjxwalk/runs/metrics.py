"""One line of figures for each generation, as the file `metrics.jsonl`.

Each line ends with a checksum of what comes before it: the CRC-32 of the line without it.
"""

import zlib
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from mjxwalk.runs import files

FILE = "metrics.jsonl"


class Metrics(msgspec.Struct, frozen=True, kw_only=True):
    """What a generation did. A figure without a value, such as the cost of no transport, is None.

    Attributes:
      generation: counted from 1.
      best_fitness: of the fittest genotype, a mean over its terrains as all fitness is.
      mean_fitness: of those that have one.
      median_fitness: of those that have one.
      best_distance_m: of the fittest genotype.
      mean_distance_m: of all.
      median_distance_m: of all.
      fall_share: of all trials.
      diverged_share: of all trials: those whose physics diverged.
      speed_m_s: of the fittest genotype.
      cost_of_transport: of the fittest genotype: work over weight times distance.
      physics_steps: in all trials.
      steps_per_s: of the physics, while evaluating.
      evaluate_s: wall time of the trials, without compiling.
      compile_s: wall time of compiling, in the first generation after a start.
      other_s: wall time of the rest: the strategy, and waiting for the disk.
      strategy: scalars that the strategy itself reports.
    """

    generation: int
    best_fitness: float | None
    mean_fitness: float | None
    median_fitness: float | None
    best_distance_m: float | None
    mean_distance_m: float | None
    median_distance_m: float | None
    fall_share: float
    diverged_share: float
    speed_m_s: float | None
    cost_of_transport: float | None
    physics_steps: int
    steps_per_s: float
    evaluate_s: float
    compile_s: float
    other_s: float
    strategy: dict[str, float | None]

    @property
    def wall_s(self) -> float:
        """Wall time of the whole generation."""
        return self.evaluate_s + self.compile_s + self.other_s


class _Line(Metrics, frozen=True, kw_only=True, forbid_unknown_fields=True):
    crc: str | None = None  # older versions wrote none


def append(folder: Path, metrics: Metrics) -> None:
    """Adds a generation's line.

    Raises:
      RunError: it cannot be written, for example because the disk is full.
    """
    files.append_line(folder / FILE, _encoded(metrics))


def read(folder: Path) -> list[Metrics]:
    """Returns the lines of a run up to the first that is cut short, as by a kill, or damaged.

    Raises:
      RunError: the file cannot be read.
    """
    path = folder / FILE
    lines: list[Metrics] = []
    for raw in files.read(path).split(b"\n")[:-1] if path.exists() else []:
        line = _decoded(raw)
        if line is None or line.generation != len(lines) + 1:
            break
        lines.append(line)
    return lines


def _encoded(metrics: Metrics) -> bytes:
    line = msgspec.json.encode(metrics)
    return line[:-1] + b',"crc":"%08x"}' % zlib.crc32(line)


def _decoded(raw: bytes) -> Metrics | None:
    """Returns a line's figures, None if it is damaged."""
    try:
        line = msgspec.json.decode(raw, type=_Line)
    except files.MALFORMED:
        return None
    metrics = Metrics(**{name: getattr(line, name) for name in Metrics.__struct_fields__})
    return metrics if line.crc is None or raw == _encoded(metrics) else None


def cut(folder: Path, generation: int) -> list[Metrics]:
    """Removes the lines after a generation from the file, and returns those that stay.

    Raises:
      RunError: the file cannot be written.
    """
    kept = read(folder)[:generation]
    content = b"".join(_encoded(line) + b"\n" for line in kept)
    files.replace(folder / FILE, content)
    return kept


def columns(lines: list[Metrics]) -> dict[str, npt.NDArray[Any]]:
    """Returns each figure as an array over generations, NaN where it has no value.

    The strategy's own are named `strategy.<name>`.
    """
    table: dict[str, npt.NDArray[Any]] = {}
    for name in Metrics.__struct_fields__:
        if name != "strategy":
            values = [getattr(line, name) for line in lines]
            whole = name in ("generation", "physics_steps")
            table[name] = np.array(values, np.int64 if whole else np.float64)
    for name in dict.fromkeys(key for line in lines for key in line.strategy):
        values = [line.strategy.get(name) for line in lines]
        table[f"strategy.{name}"] = np.array(values, np.float64)
    return table
