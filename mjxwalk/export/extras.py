"""Packages that not everybody installs."""

import importlib
from typing import Any

from mjxwalk import installing
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
            f"{purpose} needs {package}, which is not installed; add it with: "
            f"{installing.of_extra(extra)}"
        ) from None
