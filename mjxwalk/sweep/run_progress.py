"""How the runs of a sweep get on, read from their folders: nothing has to be told by them."""

from pathlib import Path
from typing import NamedTuple

from mjxwalk.errors import RunError
from mjxwalk.runs import config, metrics, result


class RunProgress(NamedTuple):
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


def read(path: Path) -> RunProgress:
    """Returns what a run's folder tells; of what is damaged, nothing."""
    if not (path / config.FILE).is_file():
        return RunProgress()
    try:
        total = int(config.read_data(path)["experiment"].get("generations", 0))
        finished = result.read(path)
        lines = metrics.read_latest(path)
    except (RunError, TypeError, ValueError, AttributeError):
        return RunProgress(is_begun=True)
    generation = lines[-1].generation if lines else 0
    if finished is not None:
        best = finished.champion.distance_m
        return RunProgress(True, True, finished.generations, total, best, 0.0)
    typical = (
        sorted(line.wall_s - line.compile_s for line in lines)[len(lines) // 2] if lines else 0
    )
    return RunProgress(
        is_begun=True,
        generation=generation,
        total=total,
        best_m=lines[-1].best_distance_m if lines else None,
        left_s=typical * (total - generation) if lines else None,
    )
