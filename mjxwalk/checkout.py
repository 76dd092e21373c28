"""Where the parts of this package are: all in one folder, or in a checkout without symbolic links.

A checkout has mjxwalk.envs and mjxwalk.strategies in top-level folders, to which links in mjxwalk
lead. Where git makes no links, as on Windows, Python finds these two through here.
"""

import sys
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path

PACKAGE = Path(__file__).parent
# Folders beside the package, by the names of the modules that they are.
BESIDE = {
    f"mjxwalk.{name}": PACKAGE.parent / name
    for name in ("envs", "strategies")
    if not (PACKAGE / name).is_dir() and (PACKAGE.parent / name).is_dir()
}


class Finder:
    """Finds the modules that are beside the package, and no other of a checkout's folders."""

    @staticmethod
    def find_spec(name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        """Returns where a module is, None if it is not one of these."""
        return PathFinder.find_spec(name, [str(PACKAGE.parent)]) if name in BESIDE else None


if BESIDE:
    sys.meta_path.append(Finder)
