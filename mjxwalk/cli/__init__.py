"""The command line. Nothing here imports JAX before the arguments are parsed."""

from mjxwalk.cli.entry import main, run

__all__ = ["main", "run"]
