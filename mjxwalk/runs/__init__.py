"""Runs on disk: a folder with settings, checkpoints and figures. `load` reads one."""

from mjxwalk.errors import Interrupted, RunError
from mjxwalk.runs.config import Config
from mjxwalk.runs.metrics import Metrics
from mjxwalk.runs.reading import Run, load
from mjxwalk.runs.result import Champion, Result

__all__ = [
    "Champion",
    "Config",
    "Interrupted",
    "Metrics",
    "Result",
    "Run",
    "RunError",
    "load",
]
