"""Opens a user's MJCF or URDF file as MuJoCo does, without what only decorates."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mjxwalk.envs._mujoco import compiled, mujoco
from mjxwalk.envs.mjcf import lines, messages, missing, urdf
from mjxwalk.envs.mjcf.lines import Place

_DECORATION = ("textures", "skins", "sensors", "cameras", "lights", "tuples", "texts")


class Opened(NamedTuple):
    """A file that MuJoCo has read.

    Attributes:
      model: the `mujoco.MjModel`.
      statistic: what the file gives of the model's statistic.
      places: the elements of the file.
      notes: what of the file is not taken, as sentences.
    """

    model: Any
    statistic: dict[str, Any]
    places: Sequence[Place]
    notes: list[str]


def opened(path: Path) -> Opened:
    """Returns the compiled model of a file.

    Raises:
      ValueError: it is no MJCF or URDF that can be a body; the message says why.
    """
    if not path.exists():
        raise ValueError("it does not exist; name an MJCF or URDF file")
    if path.is_dir():
        raise ValueError("it is a folder; name an MJCF or URDF file")
    places = lines.places(path)
    lines.check_numbers(places)
    notes: list[str] = []
    try:
        spec = _read(path, places, notes)
    except UnicodeDecodeError:
        raise
    except (ValueError, mujoco.FatalError) as error:
        raise ValueError(messages.sentence(str(error), places)) from None
    _undecorate(spec)
    missing.take_out(spec, places, notes)
    statistic = {
        name: getattr(spec.stat, name)
        for name in ("meaninertia", "meanmass", "meansize", "extent", "center")
    }
    try:
        model = compiled(spec)
        if not 0.0 < model.opt.timestep < np.inf:
            raise ValueError("the timestep of <option> is no number above 0; write one, in seconds")
    except ValueError as error:
        raise ValueError(messages.sentence(str(error), places)) from None
    return Opened(
        model,
        {name: value for name, value in statistic.items() if _is_given(value)},
        places,
        notes,
    )


def _read(path: Path, places: Sequence[Place], notes: list[str]) -> Any:
    """Returns the `mujoco.MjSpec` of a file."""
    if places and places[0].tag == "robot":
        return urdf.read(path, notes)
    return mujoco.MjSpec.from_file(str(path.resolve()))


def _is_given(value: Any) -> bool:
    return not any(math.isnan(each) for each in (value if hasattr(value, "__len__") else [value]))


def _undecorate(spec: Any) -> None:
    """Takes out what only decorates: it may need files, and is not written."""
    for kind in _DECORATION:
        for each in list(getattr(spec, kind)):
            spec.delete(each)
    for material in spec.materials:
        material.textures = ["" for _ in material.textures]
    for number in list(spec.numerics):
        # Gymnasium's way to say in which pose a trial starts.
        if number.name == "init_qpos" and not any(key.name == "init" for key in spec.keys):
            spec.add_key(name="init", qpos=number.data)
        spec.delete(number)
