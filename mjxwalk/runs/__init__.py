"""Runs on disk: a folder with settings, checkpoints and figures. `load` reads one."""

from collections.abc import Mapping
from typing import Any

import numpy.typing as npt

from mjxwalk.errors import Interrupted, RunError
from mjxwalk.runs.metrics import Metrics
from mjxwalk.runs.reading import Run, load
from mjxwalk.runs.result import Champion, Result


def unflatten(template: Any, arrays: Mapping[str, npt.NDArray[Any]]) -> Any:
    """Returns named arrays, such as a champion's, in the structure of a template.

    Raises:
      RunError: they do not fit.
    """
    from mjxwalk.runs import trees  # imports JAX, which all else here does without

    return trees.unflatten(template, arrays)


__all__ = [
    "Champion",
    "Interrupted",
    "Metrics",
    "Result",
    "Run",
    "RunError",
    "load",
    "unflatten",
]
