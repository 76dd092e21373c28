"""Runs the command line as `python -m mjxwalk`."""

import sys

from mjxwalk.cli import program

sys.exit(program())
