"""How a run gets on, in a terminal or, off one, in plain lines."""

import sys
import threading
import time
from pathlib import Path
from typing import Any

from mjxwalk import terminal
from mjxwalk.cli.progress_text import Clock, closing, duration, figures, opening
from mjxwalk.experiments.run_config import Config
from mjxwalk.progress import Progress
from mjxwalk.runs import Metrics, Result

LINE_INTERVAL = 1.0  # s between plain lines: generations may take milliseconds
PATIENCE = 2.0  # s of compiling before it is said


def make_progress() -> Progress:
    """Returns the live display on a terminal, plain lines elsewhere."""
    if sys.stdout.isatty():
        from mjxwalk.cli.progress_live import LiveProgress

        return LiveProgress()
    return PlainProgress()


class PlainProgress:
    """A line for each generation, or for each second where they are faster."""

    def __init__(self) -> None:
        self._clock = Clock(0)
        self._shown_at = -LINE_INTERVAL
        self._total = 0
        self._experiment: Any = None
        self._waiting: threading.Timer | None = None

    def start(self, path: Path, config: Config, evaluator: Any) -> None:
        """Prints the experiment and the engine."""
        self._total = config.experiment.generations
        self._clock = Clock(self._total)
        self._experiment = config.experiment
        for line in opening(path, config, evaluator):
            self.say(line)
        text = "compiling and evaluating the first generation ..."
        self._waiting = threading.Timer(PATIENCE, self.say, [text])
        self._waiting.daemon = True
        self._waiting.start()

    def generation(self, line: Metrics) -> None:
        """Prints the generation if it is time to."""
        self.close()
        self._clock.tick(line)
        if line.compile_s > 0:
            self.say(f"compiled in {line.compile_s:.1f} s")
        now = time.monotonic()
        if now - self._shown_at < LINE_INTERVAL and line.generation != self._total:
            return
        self._shown_at = now
        pieces = [f"{name} {value}" for name, value in figures(line, self._experiment)]
        left = f"{duration(self._clock.left_s)} left"
        self.say(f"generation {line.generation}/{self._total}: {', '.join(pieces)}, {left}")

    def say(self, text: str) -> None:
        """Prints a line at once."""
        terminal.say(text)

    def close(self) -> None:
        """Waits for nothing more; lines are final."""
        if self._waiting is not None:
            self._waiting.cancel()

    def finish(self, path: Path, config: Config, result: Result) -> None:
        """Prints the closing lines."""
        for line in closing(path, config, result):
            self.say(line)
