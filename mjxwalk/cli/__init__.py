"""The command line. Nothing here imports JAX before the arguments are parsed."""

from mjxwalk.cli.entry import main, program, run

__all__ = ["main", "program", "run"]
