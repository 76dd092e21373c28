"""A sweep in a terminal: a table that lives or, off one, plain lines."""

import sys
import time
from collections.abc import Mapping
from pathlib import Path

from rich.console import Console
from rich.live import Live
from rich.table import Table

from mjxwalk import terminal
from mjxwalk.cli.progress_text import duration
from mjxwalk.sweep.running import Display, Row

LINE_INTERVAL = 10.0  # s between plain lines that tell how far everything is
MOST_ROWS = 30  # of the table on a terminal: of more runs, those that run are shown
STYLES = {"running": "cyan", "finished": "green", "failed": "red", "waiting": "dim"}


def make_display() -> Display:
    """Returns the table on a terminal, plain lines elsewhere."""
    return LiveDisplay() if sys.stdout.isatty() else PlainDisplay()


class PlainDisplay:
    """A line for each run that starts or ends, and now and then one for all of them."""

    def __init__(self) -> None:
        self._states: dict[str, str] = {}
        self._shown_at = time.monotonic()
        self._clock = Clock()

    def start(self, path: Path, where: str, rows: Mapping[str, Row]) -> None:
        """Prints how many runs there are, and where they run."""
        self._states = {name: row.state for name, row in rows.items()}
        self.say(opening(path, where, rows))

    def update(self, rows: Mapping[str, Row], slots: int) -> None:
        """Prints what has changed."""
        for name, row in rows.items():
            if row.state != self._states[name] and row.state != "failed":  # that is said
                self.say(f"{name} {row.state}{_result(row)}")
            self._states[name] = row.state
        if time.monotonic() - self._shown_at > LINE_INTERVAL:
            self._shown_at = time.monotonic()
            self.say(summary(rows, self._clock.left(rows, slots)))

    def say(self, text: str) -> None:
        """Prints a line at once."""
        terminal.say(text)

    def close(self) -> None:
        """Does nothing: lines are final."""


class LiveDisplay:
    """A table that stays in place."""

    def __init__(self, console: Console | None = None) -> None:
        self._console = console or terminal.console()
        self._live: Live | None = None
        self._clock = Clock()

    def start(self, path: Path, where: str, rows: Mapping[str, Row]) -> None:
        """Opens the display."""
        text = terminal.visible(opening(path, where, rows))
        self._console.print(text, style="bold", markup=False, soft_wrap=True)
        self._live = Live(console=self._console, refresh_per_second=4)
        self._live.start()

    def update(self, rows: Mapping[str, Row], slots: int) -> None:
        """Shows the table anew."""
        if self._live is not None:
            self._live.update(table(rows, self._clock.left(rows, slots)))

    def say(self, text: str) -> None:
        """Prints a sentence above the table."""
        # Not broken where the terminal ends: what is to be typed is copied from there.
        self._console.print(terminal.visible(text), markup=False, soft_wrap=True)

    def close(self) -> None:
        """Leaves the last table on the terminal."""
        live, self._live = self._live, None
        if live is not None:
            live.stop()


class Clock:
    """The time that a sweep still needs, from the generations that it has seen go by."""

    def __init__(self) -> None:
        self._begun: tuple[float, int] | None = None

    def left(self, rows: Mapping[str, Row], slots: int) -> float | None:
        """Returns seconds until the last run ends, None before there is anything to go by."""
        del slots  # the pace of all runs together holds the slots
        done = sum(_generations(row, row.progress.generation) for row in rows.values())
        total = max((row.progress.total for row in rows.values()), default=0)
        if not total:
            return None
        now = time.monotonic()
        if self._begun is None:
            self._begun = now, done
        began, already = self._begun
        if done == already:
            return None
        left = sum(
            (row.progress.total or total) - row.progress.generation
            for row in rows.values()
            if row.state in ("waiting", "running")
        )
        return left * (now - began) / (done - already)


def _generations(row: Row, evaluated: int) -> int:
    # What ends before its last generation brings the end as near as what goes through all.
    return row.progress.total if row.state == "finished" and row.progress.total else evaluated


def opening(path: Path, where: str, rows: Mapping[str, Row]) -> str:
    """Returns what is said before the first run."""
    done = sum(row.state == "finished" for row in rows.values())
    already = f", {done} of them finished before" if done else ""
    return f"{len(rows)} runs{already}, in {path}: {where}"


def summary(rows: Mapping[str, Row], left_s: float | None) -> str:
    """Returns how far everything is, in a line."""
    counts = {state: 0 for state in ("finished", "running", "waiting", "failed", "stopped")}
    for row in rows.values():
        counts[row.state] += 1
    told = ", ".join(f"{number} {state}" for state, number in counts.items() if number)
    best = [row.progress.best_m for row in rows.values() if row.progress.best_m is not None]
    farthest = f", best {max(best):.2f} m" if best else ""
    return f"{told}{farthest}" + (f", {duration(left_s)} left" if left_s is not None else "")


def table(rows: Mapping[str, Row], left_s: float | None) -> Table:
    """Returns a row for each run, or for those that matter now."""
    shown = dict(rows)
    if len(rows) > MOST_ROWS:
        shown = {n: r for n, r in rows.items() if r.state in ("running", "failed", "stopped")}
    found = Table(box=None, pad_edge=False, caption=summary(rows, left_s), caption_justify="left")
    for column in ("run", "state", "generation", "best", "left"):
        found.add_column(column, justify="left" if column in ("run", "state") else "right")
    for name, row in list(shown.items())[:MOST_ROWS]:
        look = row.progress
        found.add_row(
            name,
            row.state,
            f"{look.generation}/{look.total}" if look.total else "-",
            "-" if look.best_m is None else f"{look.best_m:.2f} m",
            duration(look.left_s) if row.state == "running" and look.left_s is not None else "",
            style=STYLES.get(row.state, ""),
        )
    return found


def _result(row: Row) -> str:
    if row.state != "finished" or row.progress.best_m is None:
        return ""
    return f": {row.progress.generation} generations, champion {row.progress.best_m:.2f} m"
