"""Writes a run's figures for TensorBoard, generation by generation.

Not by tensorboardX's SummaryWriter: where its thread fails, the run would wait for it for ever.
"""

import contextlib
import importlib
import secrets
import time
from pathlib import Path
from typing import Any

import msgspec

from mjxwalk.errors import RunError
from mjxwalk.experiments.run_config import Config
from mjxwalk.progress import Progress
from mjxwalk.runs import Metrics, Result, files

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
        if self._path is None:
            return
        try:
            self._write(self._path, line)
        except (OSError, RunError) as error:
            why = files.describe(error) if isinstance(error, OSError) else str(error)
            self._inner.say(f"no more figures for TensorBoard: {why}")
            self._path = None

    def _write(self, path: Path, line: Metrics) -> None:
        from tensorboardX.event_file_writer import EventsWriter

        # An extra, whose names for what it writes are made as it is imported.
        events: Any = importlib.import_module("tensorboardX.proto.event_pb2")
        figures: Any = importlib.import_module("tensorboardX.proto.summary_pb2")
        step, now = line.generation, time.time()
        if self._writer is None:
            files.make_folder(path.parent, FOLDER)
            # Absolute, since tensorboardX takes what is before a colon for a place in the cloud.
            # Nobody can have put a link at a name that is drawn.
            ending = f".{step}.{secrets.token_hex(8)}"
            self._writer = EventsWriter(str(path.absolute() / "events"), ending)
            # TensorBoard drops what it has from this step on.
            start = events.SessionLog(status=events.SessionLog.START)
            self._writer.write_event(events.Event(step=step, wall_time=now, session_log=start))
        values = [figures.Summary.Value(tag=n, simple_value=v) for n, v in scalars(line).items()]
        summary = figures.Summary(value=values)
        self._writer.write_event(events.Event(step=step, wall_time=now, summary=summary))
        self._writer.flush()

    def say(self, text: str) -> None:
        """Shows a sentence."""
        self._inner.say(text)

    def close(self) -> None:
        """Ends the file; the next phase of a study begins another."""
        writer, self._writer = self._writer, None
        if writer is not None:
            with contextlib.suppress(OSError):  # each generation is written already
                writer.close()
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
