"""Bodies that ship as files, in C MuJoCo."""

import functools
import re
from typing import Any

import numpy as np

from mjxwalk import robots
from mjxwalk.envs._mujoco import mujoco

FILES = sorted(path.stem for path in robots.FOLDER.glob("*.xml"))
# The makers' own: of places, m, and of masses, kg/kg.
ASYMMETRY = {name: (1e-6, 1e-6) for name in FILES} | {
    "g1": (2e-5, 1e-6),
    "t1": (2e-3, 0.04),
    "apollo": (0.011, 3e-3),
    "berkeley_humanoid": (1e-4, 1e-5),
}
SIDES = re.compile(r"left|Left|^(ll|LL|l)(?=_)|^AL(?=\d)")
OTHER = {"left": "right", "Left": "Right", "ll": "lr", "l": "r", "AL": "AR", "LL": "LR"}


@functools.cache
def compiled(name: str, floor: bool = False) -> Any:
    """Returns a body's `mujoco.MjModel`, on a floor if asked; not to be changed."""
    spec = mujoco.MjSpec.from_file(str(robots.path(name)))
    if floor:
        plane = mujoco.mjtGeom.mjGEOM_PLANE
        spec.worldbody.add_geom(name="floor", type=plane, size=[0, 0, 1], conaffinity=0)
    return spec.compile()


def at_home(model: Any) -> Any:
    """Returns the data of a body in its keyframe `home`."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    mujoco.mj_forward(model, data)
    return data


def mirrored(name: str) -> str:
    """Returns the name of a left part's partner; of any other part, its own."""
    return SIDES.sub(lambda side: OTHER[side[0]], name)


def height(model: Any, data: Any, geom: int) -> float:
    """Returns how far a geom is above a floor at 0, m."""
    where = np.zeros(6)
    return float(mujoco.mj_geomDistance(model, data, geom, model.geom("floor").id, 5.0, where))
