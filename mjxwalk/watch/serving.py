"""Serves a page on localhost to whoever sits at this machine, beside work that must not notice.

waitress bounds connections, their time and their memory; a browser is told nothing unless it asked
for this machine by name, since any site can give a name of its own to 127.0.0.1 (DNS rebinding).
"""

import logging
import threading
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from waitress.server import create_server

from mjxwalk.errors import RunError

ADDRESS = "127.0.0.1"
CONNECTIONS = 64  # ours: a browser opens six; the run needs file descriptors as well
IDLE = 5.0  # s until a connection that says nothing is closed; the page asks more often
HEADERS = [
    ("Cache-Control", "no-store"),
    ("X-Content-Type-Options", "nosniff"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
]


class Answer(NamedTuple):
    """What is answered: a status such as "200 OK", the content and its type."""

    status: str
    content: bytes = b""
    kind: str = "text/plain"


NOT_FOUND = Answer("404 Not Found")
Find = Callable[[str, str], Answer]  # from a path and a query


class Serving:
    """A server that runs in threads of its own until it is closed.

    Attributes:
      port: that it listens to.
    """

    def __init__(self, find: Find, port: int) -> None:
        """Begins to serve.

        Args:
          find: returns what is answered; called by several threads.
          port: of localhost, if it is free; 0 for any.

        Raises:
          RunError: no port can be listened to.
        """
        # What is wrong with a request is told to whoever sent it, not to the run's terminal.
        logger = logging.getLogger("waitress")
        logger.propagate, logger.handlers = False, [logging.NullHandler()]
        self._server = _listen(lambda *asked: self._answer(find, *asked), port)
        self.port = int(self._server.effective_port)
        self._hosts = {f"{name}:{self.port}" for name in ("localhost", ADDRESS, "[::1]")}
        threading.Thread(target=self._serve, name="live", daemon=True).start()

    def close(self) -> None:
        """Stops listening, and ends the threads."""
        self._server.close()
        self._server.task_dispatcher.shutdown()

    def _serve(self) -> None:
        try:
            self._server.run()
        except Exception:
            self._server.close()  # the page is gone; the run is not

    def _answer(self, find: Find, asked: dict[str, Any], start: Any) -> Iterable[bytes]:
        """Returns the content of an answer, as WSGI has it."""
        if asked.get("HTTP_HOST", "").lower() not in self._hosts:
            answer = Answer("421 Misdirected Request")
        elif asked["REQUEST_METHOD"] not in ("GET", "HEAD"):
            answer = Answer("405 Method Not Allowed")
        else:
            answer = find(asked["PATH_INFO"], asked["QUERY_STRING"])
        kind = ("Content-Type", f"{answer.kind}; charset=utf-8")
        start(answer.status, [kind, ("Content-Length", str(len(answer.content))), *HEADERS])
        return [b"" if asked["REQUEST_METHOD"] == "HEAD" else answer.content]


def _listen(application: Any, port: int) -> Any:
    """Returns a server on a port of localhost or, where that is taken, on another."""
    for each in (port, 0):
        try:
            return create_server(
                application,
                host=ADDRESS,
                port=each,
                threads=2,
                connection_limit=CONNECTIONS,
                channel_timeout=IDLE,
                cleanup_interval=1,
                max_request_header_size=1 << 14,
                max_request_body_size=1 << 10,
                asyncore_use_poll=True,  # `select` fails where a file descriptor is above 1023
                ident=None,
            )
        except OSError as error:
            reason = error
    raise RunError(f"no page can be served on localhost ({reason.strerror or reason})")
