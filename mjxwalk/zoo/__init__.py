"""Walkers that ship with mjxwalk, named `zoo:NAME` where a command takes a run."""

from pathlib import Path

from mjxwalk.errors import RunError, near
from mjxwalk.walker import Walker
from mjxwalk.zoo import entries
from mjxwalk.zoo.entries import PREFIX, Provenance

FOLDER = Path(__file__).parent


def names() -> list[str]:
    """Returns the names of all walkers."""
    return sorted(path.stem for path in FOLDER.glob("*.json"))


def provenance(name: str) -> Provenance:
    """Returns where a walker comes from, and what it can do.

    Raises:
      RunError: there is none of the name, or its file is damaged.
    """
    check(name)
    return entries.read(FOLDER, name)


def load(name: str) -> Walker:
    """Returns a walker; imports JAX.

    Raises:
      RunError: there is none of the name, or its files are damaged.
    """
    check(name)
    return entries.read_walker(FOLDER, name)


def check(name: str) -> None:
    """Raises RunError unless there is a walker of the name."""
    if name not in names():
        hint = near(name, names()) or "; it is empty"
        raise RunError(f"there is no {name!r} in the zoo{hint}")


__all__ = ["PREFIX", "Provenance", "check", "load", "names", "provenance"]
