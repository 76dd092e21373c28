"""MuJoCo and MJX behind one door: untyped modules that warn and raise in ways of their own.

Importing MJX prints. MuJoCo writes its warnings to the terminal and to a file in the folder that
the process is in, again for every time that it warns; here each is told once.
"""

import contextlib
import functools
import importlib
import io
import os
import sys
import threading
import warnings
from collections.abc import Generator
from typing import Any


def _imported() -> Any:
    """Returns MuJoCo, whatever OpenGL it is told to draw with: physics needs none."""
    try:
        return importlib.import_module("mujoco")
    except Exception:  # of MUJOCO_GL=osmesa without OSMesa, an AttributeError deep in PyOpenGL
        asked = os.environ.pop("MUJOCO_GL", None)
        if asked is None:
            raise
        for name in [each for each in sys.modules if each.partition(".")[0] == "mujoco"]:
            del sys.modules[name]  # what was imported belongs to a package that came to nothing
        os.environ["MUJOCO_GL"] = "off"
        try:
            return importlib.import_module("mujoco")
        finally:
            os.environ["MUJOCO_GL"] = asked


mujoco: Any = _imported()

with contextlib.redirect_stdout(io.StringIO()):
    # Without Warp, which is optional, the import prints a notice that is no news to anybody here.
    from mujoco import mjx as _mjx

mjx: Any = _mjx

_compiling = threading.Lock()  # Python hears the warnings of one thread at a time

# What MuJoCo and MJX raise of a model that they cannot take.
_REFUSALS = (
    mujoco.FatalError,
    mujoco.UnexpectedError,
    ValueError,
    TypeError,
    RuntimeError,
    MemoryError,
)


@contextlib.contextmanager
def refusing(doing: str) -> Generator[None]:
    """Raises ValueError, with what MuJoCo or MJX could not do and why, if they cannot.

    Args:
      doing: what they are asked for, such as "MuJoCo cannot compile it".
    """
    try:
        yield
    except _REFUSALS as error:
        said = " ".join(str(error).split())
        raise ValueError(f"{doing}: {said or type(error).__name__}") from None


def compiled(spec: Any) -> Any:
    """Returns the `mujoco.MjModel` of a `mujoco.MjSpec`.

    Raises:
      ValueError: MuJoCo cannot compile it.
    """
    with _compiling, warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        with refusing("MuJoCo cannot compile it"):
            model = spec.compile()
    for each in heard:
        _hear(str(each.message))
    return model


@functools.cache
def _tell(text: str) -> None:
    print(f"mjxwalk: MuJoCo warns: {text}", file=sys.stderr, flush=True)


def _hear(text: str) -> None:
    # The time of the warning, at its end, differs from one to the next.
    _tell(" ".join(text.partition(" Time = ")[0].split()))


if mujoco.get_mju_user_warning() is None:  # else whoever else uses MuJoCo here hears them
    mujoco.set_mju_user_warning(_hear)
