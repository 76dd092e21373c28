"""Where walkers are looked at from."""

from typing import Any

from mjxwalk.envs import LeggedEnv
from mjxwalk.envs._mujoco import mujoco

DISTANCE = 3.9  # of the camera from the walker, in lengths of its legs; ours


def beside(env: LeggedEnv, model: Any) -> Any:
    """Returns a `mujoco.MjvCamera` beside and before the walker, which looks at the origin."""
    camera = mujoco.MjvCamera()
    mujoco.mjv_defaultFreeCamera(model, camera)
    camera.azimuth, camera.elevation = 115.0, -12.0
    camera.distance = DISTANCE * env.leg_length
    return camera
