"""Ctrl-C and SIGTERM while nothing is there yet that could be saved."""

import os
import signal

TYPE_CHECKING = False  # as type checkers know it; typing takes as long as all the rest
if TYPE_CHECKING:
    from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)  # a scheduler's SIGTERM is a Ctrl-C of its own


def leave_on_signals() -> None:
    """Makes Ctrl-C and SIGTERM end the process at once and without a word, as a shell does."""
    for number in SIGNALS:
        signal.signal(number, leave)


def leave(number: int, frame: "FrameType | None") -> None:
    """Ends the process by the exit code that a shell reports for the signal."""
    del frame
    os._exit(128 + number)
