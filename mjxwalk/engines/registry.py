"""Engines by name. Naming them is quick: an engine's module is imported when it is loaded."""

import importlib
from types import MappingProxyType
from typing import Any

from mjxwalk.engines.protocol import Engine

AUTO = "auto"  # stands for the engine that suits the machine

_MODULES = MappingProxyType(
    {
        "lanes": "mjxwalk.engines.lanes",
        "lanes-xla": "mjxwalk.engines.lanes_xla",
        "mjx": "mjxwalk.engines.mjx",
    }
)
_registered: dict[str, Engine] = {}


def register(name: str, engine: Any) -> None:
    """Makes an engine known in this process by a name.

    Raises:
      ValueError: an engine has this name, or this is no engine.
    """
    if name in names():
        raise ValueError(f"there is an engine named {name!r}; choose another name")
    if not isinstance(engine, Engine):
        raise ValueError(f"an engine has vmap and devices, and {engine!r} has not")
    _registered[name] = engine


def names() -> tuple[str, ...]:
    """Returns the names that `check` accepts."""
    return (AUTO, *_MODULES, *_registered)


def check(name: str) -> None:
    """Raises ValueError unless an engine has this name."""
    if name not in names():
        raise ValueError(f"engine must be one of {', '.join(names())}, got {name!r}")


def load(name: str) -> Engine:
    """Returns the engine of a name other than `AUTO`."""
    if name in _registered:
        return _registered[name]
    module: Any = importlib.import_module(_MODULES[name])
    return module
