"""Where walkers are looked at from."""

from typing import Any

import numpy as np

from mjxwalk.envs import LeggedEnv
from mjxwalk.envs._mujoco import mujoco

DISTANCE = 3.9  # of the camera from the walker, in lengths of its legs; ours
SPREAD = (
    1.2  # by which a foot's distance from the middle asks for more room than a leg as long; ours
)


def beside(env: LeggedEnv, model: Any) -> Any:
    """Returns a `mujoco.MjvCamera` beside and before the walker, which looks at the origin."""
    camera = mujoco.MjvCamera()
    mujoco.mjv_defaultFreeCamera(model, camera)
    camera.azimuth, camera.elevation = 115.0, -12.0
    camera.distance = distance(env)
    return camera


def distance(env: LeggedEnv) -> float:
    """Returns how far from the walker a camera sees all of it, m: its legs are long, or apart."""
    model, anatomy = env.model.mujoco, env.anatomy
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    middle = data.body(anatomy.torso).xpos
    feet = [
        data.body(point.body).xpos
        + data.body(point.body).xmat.reshape(3, 3) @ point.offset
        - middle
        for point in anatomy.points
    ]
    apart = max(float(np.hypot(*foot[:2])) for foot in feet)
    return DISTANCE * max(env.leg_length, SPREAD * apart)
