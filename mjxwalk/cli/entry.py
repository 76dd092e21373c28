"""From arguments to an exit code: 0 done, 2 wrong input or a run that could not go on."""

import os
import signal
import sys
from collections.abc import Sequence

import mjxwalk
from mjxwalk import own_process, terminal
from mjxwalk.cli.commands import COMMANDS, Command, overview
from mjxwalk.errors import RunError, near, outgrown

PROGRAM = "mjxwalk"
WRONG_INPUT = 2
STOPPED = 128 + int(signal.SIGINT)  # as a shell reports a program that Ctrl-C ended


def program() -> int:
    """Runs the command of this process, which runs nothing else, and returns its exit code."""
    own_process.declare()
    return main()


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
    if name not in COMMANDS:
        return _fail(PROGRAM, f"unknown command {name!r}{near(name, COMMANDS)}")
    return run(f"{PROGRAM} {name}", COMMANDS[name].load(), rest)


def run(program: str, command: type[Command], args: Sequence[str] | None = None) -> int:
    """Runs one command, of ours or of a script, and returns its exit code.

    Args:
      program: what the user typed so far, for the help and the complaints.
      command: a dataclass of arguments.
      args: what follows; None for the arguments of this process.
    """
    from mjxwalk.cli.parsing import parse

    try:
        parsed = parse(program, command, sys.argv[1:] if args is None else args)
        _quieten()
        with terminal.showing():
            return parsed.run()
    except RunError as error:
        return _fail(program.split()[0], str(error))
    except KeyboardInterrupt:
        return STOPPED
    except BrokenPipeError:
        # The reader, such as `head`, has had enough; Python would complain when it flushes.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return WRONG_INPUT
    except Exception as error:
        told = outgrown(error)
        if told is None:
            raise
        return _fail(program.split()[0], told)


def _fail(program: str, message: str) -> int:
    # However long the message of a library that it quotes, it is one line.
    print(terminal.visible(f"{program}: {' '.join(message.split())}"), file=sys.stderr)
    return WRONG_INPUT


def _quieten() -> None:
    """Leaves the terminal to us; errors of the libraries still show."""
    import logging
    import warnings

    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "2")
    for name in ("jax", "orbax"):
        logging.getLogger(name).setLevel(logging.ERROR)
    # Through absl Orbax logs, with tracebacks, the errors that it also raises and we report.
    logging.getLogger("absl").setLevel(logging.CRITICAL)
    # Orbax leaves its asynchronous work lying when it meets a damaged checkpoint, which we report.
    warnings.filterwarnings("ignore", "coroutine .* was never awaited", RuntimeWarning)
    # A cache that cannot be written costs time only; a full disk is reported for the run itself.
    warnings.filterwarnings("ignore", "Error .* persistent compilation cache", UserWarning)
    report = sys.unraisablehook

    def report_news(unraisable: "sys.UnraisableHookArgs") -> None:
        if str(unraisable.exc_value) != "Event loop is closed":
            report(unraisable)

    sys.unraisablehook = report_news
