"""Serves the page of a run's best walker while the run goes on, anew each generation.

A thread records the walker of the newest checkpoint; generations that pass meanwhile are left out,
so that the run waits for nothing. The page asks for what is new every second or two.
"""

import re
import threading
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from mjxwalk.errors import RunError, first_line
from mjxwalk.experiments.run_config import Config
from mjxwalk.progress import Progress
from mjxwalk.runs import Metrics, Result
from mjxwalk.watch.serving import NOT_FOUND, Answer, Serving

SECONDS = 10.0  # of a recording; ours: some steps, in a second or two of one core
PORT = 8765  # ours; where it is taken, the system gives another
WAITING = (
    b"<!doctype html><html lang=en><meta charset=utf-8><meta http-equiv=refresh content=2>"
    b"<title>mjxwalk</title><p>The first generation is not there yet."
)
NOTHING_NEW = Answer("204 No Content")


class Shot(NamedTuple):
    """A walker as it was recorded.

    Attributes:
      number: how many there were before.
      html: the whole page.
      news: what a page that is open needs, JSON.
    """

    number: int
    html: bytes
    news: bytes


class Live:
    """Shows a run in the terminal as another progress does, and its walker on localhost."""

    def __init__(self, inner: Progress, *, port: int = PORT) -> None:
        """Args: inner: is told all that this is. port: of localhost, if it is free; 0 for any."""
        self._inner = inner
        self._port = port
        self._path: Path | None = None
        self._shot: Shot | None = None
        self._wake, self._ending = threading.Event(), threading.Event()
        self._recorder: threading.Thread | None = None
        self._server: Serving | None = None

    @property
    def address(self) -> str:
        """Where the page is, once a run has started."""
        return f"http://localhost:{self._server.port if self._server else self._port}/"

    def start(self, path: Path, config: Config, evaluator: Any) -> None:
        """Starts serving, and says where."""
        self._inner.start(path, config, evaluator)
        self._path = path
        if self._server is None:
            try:
                self._server = Serving(self.find, self._port)
            except RunError as error:
                self._inner.say(f"{error}; the run goes on without it")
                return
        self._ending.clear()
        self._recorder = threading.Thread(target=self._record, daemon=True)
        self._recorder.start()
        self._inner.say(f"watch it walk: {self.address}")

    def generation(self, line: Metrics) -> None:
        """Has the walker recorded, unless the one before still is."""
        self._inner.generation(line)
        self._wake.set()

    def say(self, text: str) -> None:
        """Shows a sentence."""
        self._inner.say(text)

    def close(self) -> None:
        """Gives the terminal back; the page stays as it is until the program ends."""
        if self._recorder is not None:
            # A thread that still reads a checkpoint would fail as the program ends.
            self._ending.set()
            self._wake.set()
            self._recorder.join()
            self._recorder = None
        self._inner.close()

    def finish(self, path: Path, config: Config, result: Result) -> None:
        """Shows what was evolved."""
        self._inner.finish(path, config, result)

    def newest(self, after: int = -1) -> Shot | None:
        """Returns the newest recording, None if there is none after that number."""
        shot = self._shot
        return shot if shot is not None and shot.number > after else None

    def find(self, path: str, query: str) -> Answer:
        """Returns what is served: the page, or what is newer than a number that a page has."""
        if path == "/":
            shot = self._shot
            return Answer("200 OK", shot.html if shot else WAITING, "text/html")
        asked = re.fullmatch(r"after=(-1|[0-9]{1,9})", query, re.ASCII)
        if path != "/news" or asked is None:
            return NOT_FOUND
        shot = self.newest(int(asked[1]))
        return Answer("200 OK", shot.news, "application/json") if shot else NOTHING_NEW

    def _record(self) -> None:
        while not self._ending.is_set():
            self._wake.wait()
            self._wake.clear()
            if self._ending.is_set():
                return
            try:
                self._shot = self._shoot()
            except (RunError, OSError):
                continue  # its checkpoint was not there yet, or is gone already
            except Exception as error:  # whatever it is, the run is not to end by it
                self._inner.say(f"the page shows no newer walker ({first_line(error)})")
                return

    def _shoot(self) -> Shot:
        """Returns the walker of the newest checkpoint.

        Raises:
          RunError: it cannot be read.
          OSError: the system does not let it be read.
        """
        from mjxwalk.player import page, recording, shown_walkers
        from mjxwalk.player.recording import Take

        shown = shown_walkers.best(str(self._path))
        show, series = recording.perform(shown, Take(seconds=SECONDS))
        seen = self._shot.number + 1 if self._shot else 0
        news = msgspec.json.encode({"number": seen, "show": show, "series": series})
        return Shot(seen, page.render(show, series, live=seen).encode(), news)
