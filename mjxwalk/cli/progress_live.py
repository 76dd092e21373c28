"""The display of a run on a terminal."""

import time
from pathlib import Path
from typing import Any

from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from mjxwalk import terminal
from mjxwalk.cli.progress_text import Clock, closing, duration, figures, opening
from mjxwalk.experiments.run_config import Config
from mjxwalk.runs import Metrics, Result


class Waiting:
    """What is shown before the first generation; the seconds tell that it goes on."""

    def __init__(self) -> None:
        self._since = time.monotonic()

    def __rich__(self) -> Text:
        seconds = f"{time.monotonic() - self._since:.0f} s"
        return Text(f"compiling and evaluating the first generation ... {seconds}", style="dim")


class LiveProgress:
    """A bar and a table that stay in place while the run goes on."""

    def __init__(self, console: Console | None = None) -> None:
        self._console = console or terminal.console()
        self._live: Live | None = None
        self._clock = Clock(0)
        self._total = 0
        self._experiment: Any = None
        self._compile_s = 0.0

    def start(self, path: Path, config: Config, evaluator: Any) -> None:
        """Opens the display."""
        self._total = config.experiment.generations
        self._clock = Clock(self._total)
        self._experiment = config.experiment
        first, *rest = opening(path, config, evaluator)
        self._console.print(terminal.visible(first), style="bold", markup=False, soft_wrap=True)
        for line in rest:
            self.say(line)
        self._live = Live(Waiting(), console=self._console, refresh_per_second=4)
        self._live.start()

    def generation(self, line: Metrics) -> None:
        """Updates bar and table."""
        self._clock.tick(line)
        if line.compile_s > 0:
            self.say(f"compiled in {line.compile_s:.1f} s")
        if self._live is not None:
            self._live.update(self._render(line))

    def say(self, text: str) -> None:
        """Prints a sentence above the display."""
        # Not broken where the terminal ends: what is to be typed is copied from there.
        self._console.print(terminal.visible(text), markup=False, soft_wrap=True)

    def close(self) -> None:
        """Leaves the last figures on the terminal."""
        live, self._live = self._live, None
        if live is not None:
            live.stop()

    def finish(self, path: Path, config: Config, result: Result) -> None:
        """Prints the closing lines."""
        for number, line in enumerate(closing(path, config, result)):
            style = "bold" if number == 1 else ""
            self._console.print(terminal.visible(line), style=style, markup=False, soft_wrap=True)

    def _render(self, line: Metrics) -> Group:
        bar = Table.grid(padding=(0, 1))
        left = f"{duration(self._clock.left_s)} left"
        bar.add_row(
            f"generation {line.generation}/{self._total}",
            ProgressBar(total=self._total, completed=line.generation, width=30),
            left,
        )
        table = Table.grid(padding=(0, 2))
        for name, value in figures(line, self._experiment):
            table.add_row(Text(name, style="dim"), value)
        return Group(bar, table)
