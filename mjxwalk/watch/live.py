"""Serves the page of a run's best walker while the run goes on, anew each generation.

A thread records the walker of the newest checkpoint; generations that pass meanwhile are left out,
so that the run waits for nothing. The page asks for what is new every second or two.
"""

import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import parse_qs, urlsplit

import msgspec

from mjxwalk.errors import RunError
from mjxwalk.progress import Progress
from mjxwalk.runs import Config, Metrics, Result

SECONDS = 10.0  # of a recording; ours: some steps, in a second or two of one core
PORT = 8765  # ours; where it is taken, the system gives another
WAITING = (
    b"<!doctype html><html lang=en><meta charset=utf-8><meta http-equiv=refresh content=2>"
    b"<title>mjxwalk</title><p>The first generation is not there yet."
)


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
        self._server: ThreadingHTTPServer | None = None

    @property
    def address(self) -> str:
        """Where the page is, once a run has started."""
        port = self._server.server_address[1] if self._server else self._port
        return f"http://localhost:{port}/"

    def start(self, path: Path, config: Config, evaluator: Any) -> None:
        """Starts serving, and says where."""
        self._inner.start(path, config, evaluator)
        self._path = path
        if self._server is None:
            self._server = listen(self, self._port)
            threading.Thread(target=self._server.serve_forever, daemon=True).start()
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

    def _record(self) -> None:
        from mjxwalk.watch import casting, page, recording
        from mjxwalk.watch.recording import Trial

        while not self._ending.is_set():
            self._wake.wait()
            self._wake.clear()
            if self._ending.is_set():
                return
            try:
                cast = casting.best(str(self._path))
                show, series = recording.perform(cast, Trial(seconds=SECONDS))
            except (RunError, OSError):
                continue  # its checkpoint was not there yet, or is gone already
            seen = self._shot.number + 1 if self._shot else 0
            news = msgspec.json.encode({"number": seen, "show": show, "series": series})
            self._shot = Shot(seen, page.render(show, series, live=seen).encode(), news)


def listen(live: Live, port: int) -> ThreadingHTTPServer:
    """Returns a server of the page on localhost; where the port is taken, on another."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:  # the name that http.server asks for
            asked = urlsplit(self.path)
            if asked.path == "/":
                shot = live.newest()
                self._send(HTTPStatus.OK, shot.html if shot else WAITING, "text/html")
            elif asked.path == "/news":
                after = parse_qs(asked.query).get("after", ["-1"])[0]
                shot = live.newest(int(after)) if after.lstrip("-").isdigit() else None
                status = HTTPStatus.OK if shot else HTTPStatus.NO_CONTENT
                self._send(status, shot.news if shot else b"", "application/json")
            else:
                self._send(HTTPStatus.NOT_FOUND, b"", "text/plain")

        def _send(self, status: HTTPStatus, content: bytes, kind: str) -> None:
            self.send_response(status)
            self.send_header("Content-Type", f"{kind}; charset=utf-8")
            self.send_header("Content-Length", str(len(content)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, format: str, *args: Any) -> None:
            """Leaves the terminal to the run."""

    try:
        return ThreadingHTTPServer(("127.0.0.1", port), Handler)
    except OSError:
        return ThreadingHTTPServer(("127.0.0.1", 0), Handler)
