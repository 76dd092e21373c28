"""Runs the command line as `python -m mjxwalk`."""

import sys

from mjxwalk.cli import main

sys.exit(main())
