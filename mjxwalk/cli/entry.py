"""From arguments to an exit code: 0 done, 2 wrong input or a run that could not go on."""

import contextlib
import os
import signal
import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import mjxwalk
from mjxwalk import terminal
from mjxwalk.cli import process
from mjxwalk.cli.signals import leave_on_signals

if TYPE_CHECKING:
    from mjxwalk.cli.commands import Command

PROGRAM = "mjxwalk"
WRONG_INPUT = 2
STOPPED = 128 + int(signal.SIGINT)  # as a shell reports a program that Ctrl-C ended
# Of a program whose reader, such as `head`, ended; Windows has no such signal.
NO_READER = 128 + int(getattr(signal, "SIGPIPE", 13))


def main(args: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit code.

    Args:
      args: what follows the program's name; None for those of this process, which is then the
        command's own.
    """
    left_out = process.own() if args is None else None
    return _guarded(PROGRAM, lambda: _main(sys.argv[1:] if args is None else args, left_out))


def run(program: str, command: "type[Command]", args: Sequence[str] | None = None) -> int:
    """Runs one command, of ours or of a script, and returns its exit code.

    Args:
      program: what the user typed so far, for the help and the complaints.
      command: a dataclass of arguments.
      args: what follows; None for the arguments of this process, which is then the command's own.
    """
    left_out = process.own() if args is None else None
    rest = sys.argv[1:] if args is None else args
    return _guarded(program.split()[0], lambda: _run(program, command, rest, left_out))


def _main(args: Sequence[str], left_out: Sequence[str] | None) -> int:
    from mjxwalk.cli.commands import COMMANDS, overview
    from mjxwalk.errors import near

    name, *rest = args or ["--help"]
    if name in ("--help", "-h", "help"):
        print(overview(PROGRAM))
        return 0
    if name in ("--version", "-V"):
        print(f"{PROGRAM} {mjxwalk.__version__}")
        return 0
    if name not in COMMANDS:
        return _fail(PROGRAM, f"unknown command {name!r}{near(name, COMMANDS)}")
    return _run(f"{PROGRAM} {name}", COMMANDS[name].load(), rest, left_out)


def _run(
    program: str,
    command: "type[Command]",
    args: Sequence[str],
    left_out: Sequence[str] | None,
) -> int:
    """Runs one command.

    Args:
      program: what the user typed so far.
      command: a dataclass of arguments.
      args: what follows.
      left_out: variables that this process was rid of; None of a process that is not ours.
    """
    from mjxwalk.cli.parsing import parse

    parsed = parse(program, command, args)
    _quieten()
    if left_out is None:
        with _pinned(), terminal.showing():
            return parsed.run()
    if left_out:
        print(
            f"mjxwalk: {', '.join(left_out)} left out of account: results depend on the arguments "
            "alone",
            file=sys.stderr,
        )
    process.check_memory()
    process.raise_on_signals()
    try:
        with _pinned(), terminal.showing():
            return parsed.run()
    finally:
        leave_on_signals()


def _pinned() -> contextlib.AbstractContextManager[None]:
    """Returns what keeps a JAX that was imported before, and may be set up, from the command.

    Where it was not, it begins without the environment's settings, and runs pin what they need.
    """
    if "jax" not in sys.modules:
        return contextlib.nullcontext()
    from mjxwalk.engines import pinning

    return pinning.pinned()


def _guarded(program: str, work: Callable[[], int]) -> int:
    """Does what is to be done, and returns the exit code whatever happens."""
    try:
        try:
            return work()
        finally:
            sys.stdout.flush()  # here, where what goes wrong is told
    except KeyboardInterrupt as stop:
        return 128 + stop.args[0] if stop.args else STOPPED
    except BrokenPipeError:
        _close_output()
        return NO_READER
    except Exception as error:
        from mjxwalk.cli import refusals

        sentence = refusals.sentence(error)
        if sentence is None:
            raise
        if isinstance(error, OSError):
            _close_output()
        return _fail(program, sentence)


def _close_output() -> None:
    """Drops what was not written yet: Python would try again, and complain, when it ends."""
    with contextlib.suppress(OSError, ValueError):
        sys.stdout.flush()
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fail(program: str, message: str) -> int:
    # However long the message of a library that it quotes, it is one line; spaces may be a name's.
    line = " ".join(filter(None, map(str.strip, message.split("\n"))))
    with contextlib.suppress(OSError):
        print(terminal.visible(f"{program}: {line}"), file=sys.stderr)
    return WRONG_INPUT


def _quieten() -> None:
    """Leaves the terminal to us; errors of the libraries still show."""
    import logging
    import warnings

    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "2")
    for name in ("jax", "matplotlib", "orbax"):
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
