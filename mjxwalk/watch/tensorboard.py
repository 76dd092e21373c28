"""Writes a run's figures for TensorBoard, generation by generation."""

from pathlib import Path
from typing import Any

import msgspec

from mjxwalk.progress import Progress
from mjxwalk.runs import Config, Metrics, Result

FOLDER = "tensorboard"


class TensorBoard:
    """Shows a run as another progress does, and keeps its figures in RUN/tensorboard."""

    def __init__(self, inner: Progress) -> None:
        """Args: inner: is told all that this is."""
        self._inner = inner
        self._path: Path | None = None
        self._writer: Any = None

    def start(self, path: Path, config: Config, evaluator: Any) -> None:
        """Says where the figures go."""
        self._inner.start(path, config, evaluator)
        self._path = path / FOLDER
        self._inner.say(f"figures for TensorBoard: tensorboard --logdir {self._path}")

    def generation(self, line: Metrics) -> None:
        """Writes all figures that have a value; those of a lost generation are replaced."""
        self._inner.generation(line)
        if self._writer is None:
            from tensorboardX import SummaryWriter

            self._writer = SummaryWriter(str(self._path), purge_step=line.generation)
        for name, value in scalars(line).items():
            self._writer.add_scalar(name, value, line.generation)

    def say(self, text: str) -> None:
        """Shows a sentence."""
        self._inner.say(text)

    def close(self) -> None:
        """Ends the file; the next phase of a study begins another."""
        if self._writer is not None:
            self._writer.close()
            self._writer = None
        self._inner.close()

    def finish(self, path: Path, config: Config, result: Result) -> None:
        """Shows what was evolved."""
        self._inner.finish(path, config, result)


def scalars(line: Metrics) -> dict[str, float]:
    """Returns a generation's figures that have a value, by name; the strategy's own in a group."""
    found = msgspec.to_builtins(line)
    found |= {f"strategy/{name}": value for name, value in found.pop("strategy").items()}
    del found["generation"]
    return {name: float(value) for name, value in found.items() if value is not None}
