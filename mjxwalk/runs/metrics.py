"""One line of figures for each generation, as the file `metrics.jsonl`.

Each line names its run, and ends with a checksum of what comes before it: the CRC-32 of the line
without it.
"""

import io
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from mjxwalk.runs import files, owner

FILE = "metrics.jsonl"
RUN_LETTERS = 8  # of a run's digest in each line; ours: as many as of the checksum
NUM_EVALUATED = "num_evaluated"
TAIL = 1 << 15  # bytes from the end of the figures: a dozen generations or more


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
      strategy: scalars that the strategy itself reports, and `NUM_EVALUATED` of a population that
        grows: genotypes that the strategy was told of.
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
    run: str | None = None  # first letters of its digest; older versions wrote neither of these
    crc: str | None = None


def append(folder: Path, metrics: Metrics) -> None:
    """Adds a generation's line.

    Raises:
      RunError: it cannot be written, for example because the disk is full.
    """
    files.append_line(folder, FILE, _encoded(metrics, _run(folder)))


def read(folder: Path) -> list[Metrics]:
    """Returns the lines of a run up to the first that is cut short, as by a kill, or damaged.

    Raises:
      RunError: the file cannot be read, or is of another run.
    """
    lines: list[Metrics] = []
    for line in _decoded(folder, io.BytesIO(files.read_inside(folder, FILE) or b"")):
        if line is None or line.generation != len(lines) + 1:
            break
        lines.append(line)
    return lines


def read_latest(folder: Path) -> list[Metrics]:
    """Returns the last lines of a run that are whole; it is quick, however many there are.

    Raises:
      RunError: the file is of another run.
    """
    # The first is cut at its front, the last may be being written.
    return [
        line for line in _decoded(folder, io.BytesIO(files.read_end(folder, FILE, TAIL))) if line
    ]


def _run(folder: Path) -> str:
    return owner.of(folder).digest[:RUN_LETTERS]


def _encoded(metrics: Metrics, run: str | None) -> bytes:
    line = msgspec.json.encode(metrics)
    if run:
        line = line[:-1] + b',"run":"%s"}' % run.encode()
    return line[:-1] + b',"crc":"%08x"}' % zlib.crc32(line)


def _decoded(folder: Path, raw_lines: Iterable[bytes]) -> Iterable[Metrics | None]:
    """Yields the figures of each line, None for one that is damaged.

    Raises:
      RunError: a line is of another run.
    """
    run = owner.of(folder)
    run = run._replace(digest=run.digest[:RUN_LETTERS])
    for raw in raw_lines:
        try:
            line = msgspec.json.decode(raw, type=_Line)
        except files.MALFORMED:
            yield None
            continue
        metrics = Metrics(**{name: getattr(line, name) for name in Metrics.__struct_fields__})
        is_whole = raw.endswith(b"\n") and (
            line.crc is None or raw[:-1] == _encoded(metrics, line.run)
        )
        if is_whole:
            run.check(folder / FILE, line.run)
        yield metrics if is_whole else None


def cut(folder: Path, generation: int) -> list[Metrics]:
    """Removes the lines after a generation from the file, and returns those that stay.

    Raises:
      RunError: the file cannot be written.
    """
    kept = read(folder)[:generation]
    run = _run(folder)
    content = b"".join(_encoded(line, run) + b"\n" for line in kept)
    files.replace(folder, FILE, content)
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
