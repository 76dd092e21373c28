"""Commands that install what is missing, into the Python that runs mjxwalk."""

import importlib.metadata
import re
import sys

from mjxwalk import shell


def command(*requirements: str) -> str:
    """Returns the command that installs packages, such as "onnx>=1.20"."""
    words = (sys.executable or "python", "-m", "pip", "install", *requirements)
    return " ".join(map(shell.quoted, words))


def of_extra(extra: str) -> str:
    """Returns the command that installs what one of mjxwalk's extras asks for."""
    ending = re.compile(rf"""extra\s*==\s*['"]{re.escape(extra)}['"]""")
    lines = [line.partition(";") for line in importlib.metadata.requires("mjxwalk") or []]
    return command(*(needed.strip() for needed, _, when in lines if ending.search(when)))
