"""The command line. Nothing here imports JAX before the arguments are parsed."""

# Hardly anything is imported here: until `program` runs, Ctrl-C ends in Python's own traceback.
from mjxwalk.cli.signals import leave_on_signals

TYPE_CHECKING = False  # as type checkers know it; typing takes as long as all the rest
if TYPE_CHECKING:
    from collections.abc import Sequence

    from mjxwalk.cli.commands import Command

__all__ = ["main", "program", "run"]


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
