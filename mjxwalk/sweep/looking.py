"""How the runs of a sweep get on, read from their folders: nothing has to be told by them."""

import os
from pathlib import Path
from typing import NamedTuple

import msgspec

from mjxwalk.errors import RunError
from mjxwalk.runs import config, metrics, result
from mjxwalk.runs.metrics import Metrics

TAIL = 1 << 15  # bytes from the end of the figures: a dozen generations or more


class Look(NamedTuple):
    """What a run's folder tells.

    Attributes:
      is_begun: whether there is a run.
      is_finished: whether it has a result.
      generation: evaluated last.
      total: generations at most; 0 where that is not known.
      best_m: distance of the champion, or of the fittest of the last generation.
      left_s: until the last generation, as far as the latest ones tell.
    """

    is_begun: bool = False
    is_finished: bool = False
    generation: int = 0
    total: int = 0
    best_m: float | None = None
    left_s: float | None = None


def look(path: Path) -> Look:
    """Returns what a run's folder tells; of what is damaged, nothing."""
    if not (path / config.FILE).is_file():
        return Look()
    try:
        total = int(config.read_data(path)["experiment"].get("generations", 0))
        finished = result.read(path)
    except (RunError, TypeError, ValueError, AttributeError):
        return Look(is_begun=True)
    lines = _latest(path / metrics.FILE)
    generation = lines[-1].generation if lines else 0
    if finished is not None:
        best = finished.champion.distance_m
        return Look(True, True, finished.generations, total, best, 0.0)
    typical = (
        sorted(line.wall_s - line.compile_s for line in lines)[len(lines) // 2] if lines else 0
    )
    return Look(
        is_begun=True,
        generation=generation,
        total=total,
        best_m=lines[-1].best_distance_m if lines else None,
        left_s=typical * (total - generation) if lines else None,
    )


def _latest(path: Path) -> list[Metrics]:
    """Returns the last lines of figures that are whole."""
    try:
        with path.open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - TAIL))
            raw = file.read(TAIL).split(b"\n")
    except OSError:
        return []
    lines: list[Metrics] = []
    for each in raw:
        try:
            lines.append(msgspec.json.decode(each, type=Metrics))
        except (msgspec.DecodeError, UnicodeDecodeError):
            continue  # cut at the front, or being written at the end
    return lines
