"""A kernel's name on disk, found without tracing: from settings and the package's own sources.

Only methods of this package's frozen settings have such a name, and only in the program's own
process, where nothing but installed code can have changed what they compute. The name depends on
all the settings, on the content of every file of this package, and on what configures JAX. An entry
also records every other file that its process had loaded, and what Python has compiled of either,
and counts only while all are unchanged.
Any other function is traced every time, and its kernel is found by the code that tracing gives.
"""

import dataclasses
import enum
import functools
import hashlib
import importlib.util
import os
import stat
import sys
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, cast

import jax
import numpy as np

from mjxwalk import own_process

PLAIN = (bool, int, float, complex, str, bytes, types.NoneType)
CONFIGURING = ("JAX", "XLA", "MJX", "MUJOCO")  # how such environment variables begin

# path: size, times of last change of content and of status in ns; nothing of a file that is missing
Stamps = dict[str, list[int]]


class Unnamed(Exception):
    """Raised for a value whose text would not say all that it is."""


def key(function: Any) -> str | None:
    """Returns a text that says what a function computes, or None if only tracing can."""
    begun = own_process.begun()
    if begun is None or not isinstance(function, types.MethodType):
        return None
    owner = function.__self__
    try:
        text = f"{_text(owner)}.{function.__name__}"
    except Unnamed:
        return None
    if function.__func__ is not getattr(type(owner), function.__name__, None):
        return None
    sources = _sources(begun)
    return None if sources is None else "\0".join((text, sources, _configuration()))


def _text(value: Any) -> str:
    """Returns the text of plain values, arrays, and this package's enums and frozen dataclasses.

    Raises:
      Unnamed: for everything else, in whatever it is contained.
    """
    kind = type(value)
    if kind in PLAIN:
        return f"{kind.__name__}:{value!r}"
    if kind in (tuple, list):
        return f"{kind.__name__}[{','.join(map(_text, value))}]"
    if kind is dict:
        pairs = cast(dict[Any, Any], value).items()
        return f"dict[{','.join(f'{_text(k)}={_text(v)}' for k, v in pairs)}]"
    if kind is np.ndarray and not value.dtype.hasobject:
        content = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return f"array:{value.dtype.str}:{value.shape}:{content}"
    if not kind.__module__.startswith("mjxwalk.") or "<locals>" in kind.__qualname__:
        raise Unnamed(repr(kind))
    name = f"{kind.__module__}.{kind.__qualname__}"
    if isinstance(value, enum.Enum):
        return f"{name}.{value.name}"
    if dataclasses.is_dataclass(value) and cast(Any, value).__dataclass_params__.frozen:
        fields = (f"{f.name}={_text(getattr(value, f.name))}" for f in dataclasses.fields(value))
        return f"{name}({','.join(fields)})"
    raise Unnamed(name)


def _configuration() -> str:
    """Returns all that configures JAX, MJX and Python, which tracing may depend on."""
    values = {name: getattr(jax.config, name, None) for name in jax.config.values}
    values.pop("jax_compilation_cache_dir", None)
    told = {name: v for name, v in os.environ.items() if name.startswith(CONFIGURING)}
    return repr((sorted(values.items()), sorted(told.items()), sys.version, sys.flags))


@functools.cache
def _sources(begun: float) -> str | None:
    """Returns the content of all files of this package as a digest.

    None if one has changed since the process began, and may not be what it loaded, or cannot be
    read; or if there are none, as in an archive that Python imports from.
    """
    found = hashlib.sha256()
    paths = sorted(_package_files())
    for path in paths:
        try:
            status = os.stat(path)
            if not stat.S_ISREG(status.st_mode) or _newest(status) > begun:
                return None
            found.update(f"{path}:{status.st_size}:".encode(errors="surrogateescape"))
            found.update(Path(path).read_bytes())
        except OSError:  # such as an editor's link that leads nowhere
            return None
    return found.hexdigest() if paths else None


def _package_files() -> Iterator[str]:
    for part in own_process.FOLDERS:
        for folder, folders, files in os.walk(part, followlinks=True):
            folders[:] = [name for name in folders if name != "__pycache__"]
            yield from (os.path.join(folder, file) for file in files)


def _newest(status: os.stat_result) -> float:
    """Returns when a file, or its name and owner, last changed, s since the epoch."""
    return max(status.st_mtime, status.st_ctime)


def _compiled(path: str) -> str:
    return importlib.util.cache_from_source(path) if path.endswith(".py") else path


class Dependencies(NamedTuple):
    """What a process had loaded besides this package: files, and where each top-level name led."""

    files: Stamps
    modules: dict[str, str]


def dependencies() -> Dependencies | None:
    """Returns what this process has loaded, or None if a file changed since the process began."""
    begun = own_process.begun()
    if begun is None:
        return None
    modules = own_process.modules()
    outside = {name: file for name, file in modules.items() if not own_process.is_ours(file)}
    files: Stamps = {path: _stamp(path) for path in outside.values()}
    # Python runs what it has compiled, which it takes for the source's by size and time alone.
    compiled = {path: _stamp(path) for path in map(_compiled, outside.values())}
    if not all(files.values()):
        return None
    if max(max(times) for _, *times in filter(None, (files | compiled).values())) > begun * 1e9:
        return None
    ours = {path: _stamp(path) for path in map(_compiled, modules.values()) if path not in compiled}
    named = {name: file for name, file in outside.items() if "." not in name}
    return Dependencies(files | compiled | ours, named)


def are_unchanged(recorded: Dependencies) -> bool:
    """Returns whether the files are unchanged, and this process loads the same ones."""
    return all(_stamp(path) == stamp for path, stamp in recorded.files.items()) and all(
        _origin(name) == file for name, file in recorded.modules.items()
    )


def _origin(name: str) -> str | None:
    """Returns the file of a top-level module, loaded or not."""
    if name in sys.modules:
        return getattr(sys.modules[name], "__file__", None)
    spec = importlib.util.find_spec(name)
    return None if spec is None else spec.origin


def _stamp(path: str) -> list[int]:
    try:
        status = os.stat(path)
    except OSError:
        return []
    return [status.st_size, status.st_mtime_ns, status.st_ctime_ns]
