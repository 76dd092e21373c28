"""Experiments by name. Naming them is quick: JAX is imported by `get` only."""

import importlib
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from mjxwalk.experiments.experiment import Experiment

__all__ = ["DEFAULT", "get", "names"]

DEFAULT = "planar-lpd"


class _Entry(NamedTuple):
    module: str
    attribute: str
    summary: str


_ENTRIES = {
    "planar-lpd": _Entry("solomon", "PLANAR_LPD", "planar walker, local links, slightly rough"),
    "planar-fil": _Entry("solomon", "PLANAR_FIL", "planar walker, all links, slightly rough"),
}


def names() -> dict[str, str]:
    """Returns each experiment's name and what it is, in a line."""
    return {name: entry.summary for name, entry in _ENTRIES.items()}


def get(name: str) -> "Experiment":
    """Returns the experiment of that name.

    Raises:
      ValueError: there is none; the message names the nearest.
    """
    if name not in _ENTRIES:
        import difflib

        near = difflib.get_close_matches(name, _ENTRIES, cutoff=0.4)
        known = f"choose from {', '.join(_ENTRIES)}"
        hint = f"did you mean {' or '.join(near)}?" if near else known
        raise ValueError(f"unknown experiment {name!r}: {hint}")
    entry = _ENTRIES[name]
    module = importlib.import_module(f"mjxwalk.experiments.{entry.module}")
    return getattr(module, entry.attribute)
