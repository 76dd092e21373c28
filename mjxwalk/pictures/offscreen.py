"""Pictures by MuJoCo without a screen, with whichever OpenGL there is."""

import functools
import importlib
import os
import subprocess
import sys
import warnings
from typing import Any

import numpy as np
from jaxtyping import UInt8

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.errors import RunError

LIBRARIES = ("egl", "osmesa")
PROBE = """
import importlib, sys
context = importlib.import_module(f"mujoco.{sys.argv[1]}").GLContext(64, 64)
context.make_current()
import mujoco
mujoco.MjrContext(mujoco.MjModel.from_xml_string("<mujoco/>"), mujoco.mjtFontScale.mjFONTSCALE_100)
"""
PROBE_SECONDS = 120  # ours: a driver that takes longer hangs


@functools.cache
def library() -> str:
    """Returns the name of an OpenGL library that draws without a screen.

    It is tried in a process of its own: a driver that is not for this machine may crash, and
    PyOpenGL cannot change the library once it has one.

    Raises:
      RunError: there is none.
    """
    asked = os.environ.get("MUJOCO_GL", "").lower()
    for name in (asked,) if asked in LIBRARIES else LIBRARIES:
        if _works(name):
            return name
    raise RunError(
        "MuJoCo finds no OpenGL that draws without a screen, neither EGL nor OSMesa; install one, "
        "on Debian or Ubuntu: apt install libegl1 libgl1-mesa-dri, or: apt install libosmesa6"
    )


def _works(name: str) -> bool:
    env = {**os.environ, "MUJOCO_GL": name, "PYOPENGL_PLATFORM": name}
    with warnings.catch_warnings():
        # JAX warns of every fork; this one does nothing but start another program.
        warnings.filterwarnings("ignore", "os.fork", RuntimeWarning)
        try:
            tried = subprocess.run(
                [sys.executable, "-c", PROBE, name],
                env=env,
                capture_output=True,
                timeout=PROBE_SECONDS,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return False
    return tried.returncode == 0


class Painter:
    """Draws a model.

    Use it in a `with` statement, which gives the OpenGL context back.
    """

    def __init__(self, model: Any, size: tuple[int, int]) -> None:
        """Readies OpenGL.

        Args:
          model: the `mujoco.MjModel`.
          size: of the pictures, pixels across and down.

        Raises:
          RunError: there is no OpenGL.
        """
        name = library()
        # MuJoCo's module for the library insists on PyOpenGL being set to the same.
        os.environ["PYOPENGL_PLATFORM"] = name
        self._context: Any = importlib.import_module(f"mujoco.{name}").GLContext(*size)
        self._context.make_current()
        self._model, self._size = model, size
        self._drawing = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_150.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._drawing)
        self._scene = mujoco.MjvScene(model, maxgeom=1000)
        self._options = mujoco.MjvOption()
        self._options.sitegroup[:] = 0  # the planar body's lie between its feet, as drawn

    def __enter__(self) -> "Painter":
        return self

    def __exit__(self, *_: object) -> None:
        self._drawing.free()
        self._context.free()

    def draw(self, data: Any, camera: Any) -> UInt8[np.ndarray, "down across 3"]:
        """Returns a picture of the model where `mj_forward` or `mj_kinematics` left it."""
        across, down = self._size
        mujoco.mjv_updateScene(
            self._model,
            data,
            self._options,
            None,
            camera,
            mujoco.mjtCatBit.mjCAT_ALL.value,
            self._scene,
        )
        view = mujoco.MjrRect(0, 0, across, down)
        mujoco.mjr_render(view, self._scene, self._drawing)
        picture = np.empty((down, across, 3), np.uint8)
        mujoco.mjr_readPixels(picture, None, view, self._drawing)
        return picture[::-1]  # OpenGL counts from the bottom
