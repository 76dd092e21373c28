"""Ctrl-C in two stages: the first ends a run in good order, the second at once."""

import os
import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any

from mjxwalk.cli.process import is_importing
from mjxwalk.cli.signals import SIGNALS


class Interrupt:
    """While entered, turns the first signal into KeyboardInterrupt in the main thread.

    Python runs a handler only between two steps of Python, so the second signal is watched by a
    thread: it ends the process even while the main thread compiles or simulates.

    Attributes:
      signal: number of the signal that came first; SIGINT if none did.
    """

    def __init__(self, say: Callable[[str], None], *, is_raised: bool = True) -> None:
        """Args: say: shows a sentence. is_raised: whether more happens than that it is noted."""
        self._is_raised = is_raised
        self.signal = int(signal.SIGINT)
        self._say = say
        self._requested = False
        self._previous: dict[int, Any] = {}

    def requested(self) -> bool:
        """Returns whether a signal came: code that is not ours may swallow the exception."""
        return self._requested

    def __enter__(self) -> "Interrupt":
        reader, self._writer = os.pipe()
        if hasattr(os, "set_blocking"):  # Windows before Python 3.12 has it for no pipe
            os.set_blocking(self._writer, False)
        self._previous = {number: signal.signal(number, self._handle) for number in SIGNALS}
        self._wakeup = signal.set_wakeup_fd(self._writer, warn_on_full_buffer=False)
        threading.Thread(target=self._watch, args=(reader,), daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        signal.set_wakeup_fd(self._wakeup)
        for number, handler in self._previous.items():
            signal.signal(number, handler)
        os.close(self._writer)  # ends the thread

    def _handle(self, number: int, frame: FrameType | None) -> None:
        first = not self._requested
        self._requested = True
        if first:
            self.signal = number
            if self._is_raised:
                if is_importing(frame):
                    os._exit(128 + number)  # what was evolved, if anything was, is saved
                raise KeyboardInterrupt

    def _watch(self, reader: int) -> None:
        count = 0
        while number := os.read(reader, 1):
            if number[0] in SIGNALS:
                count += 1
                if count == 1:
                    self._say("stopping and saving; again to stop at once")
                else:
                    os._exit(128 + number[0])
        os.close(reader)
