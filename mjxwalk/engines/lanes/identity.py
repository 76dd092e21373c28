"""What a function is, as text: the same in every process as long as its source is the same.

With it a compiled kernel is found on disk before anything is traced. A function is named by its
module, its code and all that it closes over: numbers, arrays, frozen dataclasses, other functions.
What cannot be told apart for sure has no text, and is traced. Besides the text, a kernel remembers
every source file that was loaded when it was traced, and all files of the packages that the
function came from; it holds only while none of them has changed.
"""

import dataclasses
import enum
import functools
import hashlib
import importlib
import marshal
import os
import sys
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import jax
import numpy as np

Manifest = dict[str, list[int]]  # path: size, time of last change in ns


class Unnamed(Exception):
    """Raised for a value that has no text."""


class Identity:
    """Collects the text of a value and the modules that it comes from."""

    def __init__(self) -> None:
        self.modules: set[str] = set()
        self._open: set[int] = set()

    def text(self, value: Any) -> str:
        """Returns the text of a value.

        Raises:
          Unnamed: it, or something in it, has none.
        """
        if id(value) in self._open:
            return "<itself>"
        if value is None or isinstance(value, (bool, int, float, complex, str, bytes)):
            return f"{type(value).__name__}:{value!r}"
        self._open.add(id(value))
        try:
            return self._compound(value)
        finally:
            self._open.discard(id(value))

    def _compound(self, value: Any) -> str:
        if isinstance(value, (np.ndarray, np.generic, jax.Array)):
            return _array(value)
        if isinstance(value, np.dtype):
            return f"dtype:{value.str}"
        if isinstance(value, enum.Enum):
            return f"{self._type(type(value))}.{value.name}"
        if isinstance(value, (tuple, list)):
            items = cast(list[Any], value)
            return f"{self._type(type(value))}[{','.join(map(self.text, items))}]"
        if isinstance(value, dict):
            pairs = cast(dict[Any, Any], value).items()
            return f"dict[{','.join(f'{self.text(k)}={self.text(v)}' for k, v in pairs)}]"
        if isinstance(value, type):
            return self._type(cast(type[Any], value))
        if isinstance(value, types.ModuleType):
            return f"module:{value.__name__}"
        return self._behaviour(value)

    def _behaviour(self, value: Any) -> str:
        if isinstance(value, functools.partial):
            part = cast("functools.partial[Any]", value)
            return (
                f"partial[{self.text(part.func)},{self.text(part.args)},{self.text(part.keywords)}]"
            )
        if isinstance(value, types.MethodType):
            return f"method[{self.text(value.__self__)},{self.text(value.__func__)}]"
        if isinstance(value, types.BuiltinFunctionType):
            return f"builtin:{value.__module__}.{value.__qualname__}"
        if isinstance(value, types.FunctionType):
            return self._function(value)
        wrapped = getattr(value, "__wrapped__", None)
        if wrapped is not None and type(value).__module__.startswith(("jax", "functools")):
            return f"{self._type(type(value))}[{self.text(wrapped)}]"
        if dataclasses.is_dataclass(value) and cast(Any, value).__dataclass_params__.frozen:
            fields = (
                f"{f.name}={self.text(getattr(value, f.name))}" for f in dataclasses.fields(value)
            )
            return f"{self._type(type(value))}({','.join(fields)})"
        raise Unnamed(repr(type(value)))

    def _function(self, function: types.FunctionType) -> str:
        self.modules.add(function.__module__)
        cells = [cell.cell_contents for cell in function.__closure__ or ()]
        code = hashlib.sha256(marshal.dumps(function.__code__)).hexdigest()
        parts = [
            self.text(part) for part in (function.__defaults__, function.__kwdefaults__, cells)
        ]
        return f"function:{function.__module__}.{function.__qualname__}:{code}[{','.join(parts)}]"

    def _type(self, kind: type[Any]) -> str:
        self.modules.add(kind.__module__)
        return f"{kind.__module__}.{kind.__qualname__}"


def _array(value: Any) -> str:
    array = np.asarray(value)
    if array.dtype.hasobject:
        raise Unnamed("array of objects")
    content = hashlib.sha256(np.ascontiguousarray(array).tobytes()).hexdigest()
    return f"array:{type(value).__name__}:{array.dtype.str}:{array.shape}:{content}"


def manifest(modules: set[str]) -> Manifest | None:
    """Returns size and time of every file that what is traced now may depend on.

    Args:
      modules: names of modules whose whole packages count, loaded or not.

    Returns None if a module has no file, as in an interactive session.
    """
    paths: set[str] = set()
    for module in list(sys.modules.values()):
        path = getattr(module, "__file__", None)
        if isinstance(path, str):
            paths.add(path)
    for name in modules:
        if name in sys.builtin_module_names:
            continue
        found = getattr(sys.modules.get(name), "__file__", None)
        if not isinstance(found, str):
            return None
        top = sys.modules.get(name.partition(".")[0])
        for root in getattr(top, "__path__", ()):
            if not _is_installed(str(root)):
                paths.update(_files(str(root)))
    try:
        return {path: _stamp(path) for path in sorted(paths)}
    except OSError:
        return None


def _is_installed(root: str) -> bool:
    """Returns whether a package is one that pip put there, whose loaded modules are enough."""
    return "site-packages" in Path(root).parts and not root.endswith("mjxwalk")


def _files(root: str) -> Iterator[str]:
    for folder, folders, files in os.walk(root, followlinks=True):
        folders[:] = [name for name in folders if name != "__pycache__"]
        yield from (os.path.join(folder, file) for file in files)


def _stamp(path: str) -> list[int]:
    status = os.stat(path)
    return [status.st_size, status.st_mtime_ns]


def holds(recorded: Manifest) -> bool:
    """Returns whether every file is still what it was."""
    try:
        return all(_stamp(path) == stamp for path, stamp in recorded.items())
    except OSError:
        return False


def encoded(tree: Any) -> Any:
    """Returns a tree of leaf numbers as JSON.

    Raises:
      Unnamed: it holds a container other than dict, list, tuple, NamedTuple and None.
    """
    if tree is None or isinstance(tree, int):
        return tree
    if isinstance(tree, dict):
        items = cast(dict[Any, Any], tree).items()
        if all(isinstance(key, str) for key, _ in items):
            return {"dict": [[key, encoded(value)] for key, value in items]}
    elif type(tree) in (list, tuple):
        return {type(tree).__name__: [encoded(value) for value in tree]}
    elif isinstance(tree, tuple) and hasattr(tree, "_fields"):
        kind = type(cast(Any, tree))
        if "<locals>" not in kind.__qualname__:
            values = [encoded(value) for value in cast(tuple[Any, ...], tree)]
            return {"named": f"{kind.__module__}:{kind.__qualname__}", "values": values}
    raise Unnamed(repr(type(tree)))


def decoded(text: Any) -> Any:
    """Returns the tree that `encoded` made JSON of."""
    if not isinstance(text, dict):
        return text
    parts = cast(dict[str, Any], text)
    if "dict" in parts:
        return {key: decoded(value) for key, value in parts["dict"]}
    if "named" in parts:
        module, _, name = parts["named"].partition(":")
        kind: Any = functools.reduce(getattr, name.split("."), importlib.import_module(module))
        return kind(*map(decoded, parts["values"]))
    ((name, items),) = parts.items()
    return (list if name == "list" else tuple)(map(decoded, items))
