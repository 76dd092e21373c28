"""The command line. Nothing here imports JAX before the arguments are parsed."""

# Hardly anything is imported here: until `program` runs, Ctrl-C ends in Python's own traceback.
import os
import signal

TYPE_CHECKING = False  # as type checkers know it; typing takes as long as all the rest
if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import FrameType

    from mjxwalk.cli.commands import Command

__all__ = ["SIGNALS", "leave", "leave_on_signals", "main", "program", "run"]

SIGNALS = (signal.SIGINT, signal.SIGTERM)  # a scheduler's SIGTERM is a Ctrl-C of its own


def program() -> int:
    """Runs the command of this process, which runs nothing else, and returns its exit code."""
    leave_on_signals()
    from mjxwalk import own_process

    own_process.declare()
    return main()


def main(args: "Sequence[str] | None" = None) -> int:
    """Runs one command and returns its exit code.

    Args:
      args: what follows the program's name; None for those of this process, which is then the
        command's own.
    """
    if args is None:
        leave_on_signals()
    from mjxwalk.cli import entry

    return entry.main(args)


def run(program: str, command: "type[Command]", args: "Sequence[str] | None" = None) -> int:
    """Runs one command, of ours or of a script, and returns its exit code.

    Args:
      program: what the user typed so far, for the help and the complaints.
      command: a dataclass of arguments.
      args: what follows; None for those of this process, which is then the command's own.
    """
    if args is None:
        leave_on_signals()
    from mjxwalk.cli import entry

    return entry.run(program, command, args)


def leave_on_signals() -> None:
    """Makes Ctrl-C and SIGTERM end the process at once and without a word, as a shell does."""
    for number in SIGNALS:
        signal.signal(number, leave)


def leave(number: int, frame: "FrameType | None") -> None:
    """Ends the process by the exit code that a shell reports for the signal."""
    del frame
    os._exit(128 + number)
