"""Whether this process runs the program and nothing else.

In a process that a user's script, notebook or test began, anything may have changed what a function
of this package means: a global, a class, a patched library. In the program's own process nothing
has, so that a function's settings and the package's sources say what it computes.
"""

import os
import sys
import sysconfig
import time

from mjxwalk import checkout

FOLDERS = tuple(str(folder) for folder in (checkout.PACKAGE, *checkout.BESIDE.values()))
# What every function that computes needs: nobody changed one before these were loaded.
COMPUTING = ("jax", "mujoco", "numpy")
_begun: list[float] = []  # when the program began, s since the epoch; empty in other processes


def declare() -> None:
    """Says that the program begins here; only its entry points call this.

    It does not where something was loaded that computes: a script that changes this package and
    then runs the program, or what Python loads as it starts, may have changed what that means.
    """
    _begun[:] = [] if any(name in sys.modules for name in COMPUTING) else [time.time()]


def begun() -> float | None:
    """Returns when the program began, s since the epoch, or None if this process is another's.

    It is another's, too, once it has loaded a module that is neither installed nor ours.
    """
    if not _begun or not all(map(_is_installed, modules().values())):
        return None
    return _begun[0]


def modules() -> dict[str, str]:
    """Returns the files of all modules by name, without the one that began the process."""
    files = ((name, getattr(each, "__file__", None)) for name, each in list(sys.modules.items()))
    return {name: file for name, file in files if isinstance(file, str) and name != "__main__"}


def is_ours(file: str) -> bool:
    """Returns whether a file is in this package."""
    return file.startswith(tuple(folder + os.sep for folder in FOLDERS))


def _is_installed(file: str) -> bool:
    return file.startswith(_PLACES)


def _places() -> tuple[str, ...]:
    """Returns the folders of Python's library, of installed packages and of this package."""
    names = ("stdlib", "platstdlib", "purelib", "platlib")
    found = {sysconfig.get_path(name) for name in names} | set(FOLDERS)
    found |= {place for place in sys.path if place.endswith(("site-packages", "dist-packages"))}
    return tuple(place.rstrip(os.sep) + os.sep for place in sorted(found))


_PLACES = _places()
