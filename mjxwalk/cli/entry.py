"""From arguments to an exit code: 0 done, 2 wrong input or a run that could not go on."""

import os
import signal
import sys
from collections.abc import Sequence

import mjxwalk
from mjxwalk.cli.commands import COMMANDS, overview
from mjxwalk.errors import RunError, near

PROGRAM = "mjxwalk"
WRONG_INPUT = 2
STOPPED = 128 + int(signal.SIGINT)  # as a shell reports a program that Ctrl-C ended


def main(args: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit code.

    Args:
      args: what follows the program's name; None for those of this process.
    """
    name, *rest = (sys.argv[1:] if args is None else list(args)) or ["--help"]
    if name in ("--help", "-h", "help"):
        print(overview(PROGRAM))
        return 0
    if name in ("--version", "-V"):
        print(f"{PROGRAM} {mjxwalk.__version__}")
        return 0
    try:
        return _run(name, rest)
    except RunError as error:
        # However long the message of a library that it quotes, it is one line.
        print(f"{PROGRAM}: {' '.join(str(error).split())}", file=sys.stderr)
        return WRONG_INPUT
    except KeyboardInterrupt:
        return STOPPED
    except BrokenPipeError:
        # The reader, such as `head`, has had enough; Python would complain when it flushes.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return WRONG_INPUT


def _run(name: str, args: list[str]) -> int:
    if name not in COMMANDS:
        raise RunError(f"unknown command {name!r}{near(name, COMMANDS)}")
    from mjxwalk.cli.parsing import parse

    command = parse(f"{PROGRAM} {name}", COMMANDS[name].load(), args)
    _quieten()
    return command.run()


def _quieten() -> None:
    """Leaves the terminal to us; errors of the libraries still show."""
    import logging

    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "2")
    for name in ("absl", "jax", "orbax"):
        logging.getLogger(name).setLevel(logging.ERROR)
