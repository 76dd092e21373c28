"""MuJoCo and MJX behind one door: their modules carry no types, and importing MJX prints."""

import contextlib
import io
from typing import Any

import mujoco as _mujoco

with contextlib.redirect_stdout(io.StringIO()):
    # Without Warp, which is optional, the import prints a notice that is no news to anybody here.
    from mujoco import mjx as _mjx

mujoco: Any = _mujoco
mjx: Any = _mjx
