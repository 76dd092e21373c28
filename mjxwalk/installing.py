"""Packages that not everybody installs, and the commands that install them."""

import importlib
import importlib.metadata
import re
import sys
from typing import Any

from mjxwalk import shell
from mjxwalk.errors import RunError


def load(module: str, extra: str, purpose: str) -> Any:
    """Returns a module of an optional package.

    Args:
      module: its name.
      extra: of mjxwalk, that brings it.
      purpose: what needs it, in a few words.

    Raises:
      RunError: it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        package = module.partition(".")[0].replace("_", "-")
        raise RunError(
            f"{purpose} needs {package}, which is not installed; add it with: {of_extra(extra)}"
        ) from None


def command(*requirements: str) -> str:
    """Returns the command that installs packages, such as "onnx>=1.20"."""
    words = (sys.executable or "python", "-m", "pip", "install", *requirements)
    return " ".join(map(shell.quoted, words))


def of_extra(extra: str) -> str:
    """Returns the command that installs what one of mjxwalk's extras asks for."""
    ending = re.compile(rf"""extra\s*==\s*['"]{re.escape(extra)}['"]""")
    lines = [line.partition(";") for line in importlib.metadata.requires("mjxwalk") or []]
    return command(*(needed.strip() for needed, _, when in lines if ending.search(when)))
