"""What a spatial gait may hide: feet that slide or brush the ground, flight, drift, and a lean.

Measured on recordings of `Flame`, whose sole has four corners; MuJoCo places and moves them.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from mjxwalk.analysis.footfalls import find_footfalls, observe
from mjxwalk.analysis.frame import Frame
from mjxwalk.envs import Flame
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.flame_body import CONTACT_SITES, COORDINATE, PITCH, ROLL
from mjxwalk.replay import Recording

FAULTS = ("slip", "brush", "flight", "drift", "pitch_rad", "roll_rad")


class Corners(NamedTuple):
    """How fast the soles' corners move along the ground, and which of them touch it.

    Attributes:
      speed: horizontal, m/s.
      touching: whether each is below the ground.
    """

    speed: Float[np.ndarray, "frame 8"]
    touching: Bool[np.ndarray, "frame 8"]


def measure_faults(recording: Recording, env: Flame) -> Frame:
    """Returns a row for each trial: whether it `fell`, and all of `FAULTS`.

    - slip: metres that soles slide while they bear, over metres walked. A sole slides as fast as
      the slowest of its corners that touch the ground.
    - brush: share of a foot's swing in which it touches the ground nevertheless.
    - flight: share of the trial in which no foot touches the ground.
    - drift: metres sideways over metres walked, to the left positive.
    - pitch_rad: mean lean of the torso, forward positive.
    - roll_rad: mean absolute roll of the torso.

    NaN where a trial is too short to tell.

    Args:
      recording: of trials from their start.
      env: that they are trials of.
    """
    import pandas as pd

    observations = observe(recording, env)
    rows: list[dict[str, Any]] = []
    for walker, footfalls in enumerate(find_footfalls(recording, observations)):
        frames = len(footfalls.time)
        states: Any = recording.states
        qpos = states.qpos[:frames, walker].astype(np.float64)
        qvel = states.qvel[:frames, walker].astype(np.float64)
        corners = corner_speeds(env, qpos, qvel, states.touching[:frames, walker])
        walked = float(qpos[-1, 0] - qpos[0, 0])
        raw: Any = corners.touching.reshape(-1, 2, 4).any(axis=2)
        rows.append(
            {
                "fell": bool(states.fell[-1, walker]),
                "slip": _slid(corners, footfalls.time, footfalls.contact) / walked,
                "brush": _share(raw[~footfalls.contact]),
                "flight": _share(~raw.any(axis=1)),
                "drift": float(qpos[-1, 1] - qpos[0, 1]) / walked,
                "pitch_rad": float(qpos[:, PITCH].mean()),
                "roll_rad": float(np.abs(qpos[:, ROLL]).mean()),
            }
        )
    return pd.DataFrame(rows)


def corner_speeds(
    env: Flame,
    qpos: Float[np.ndarray, "frame 15"],
    qvel: Float[np.ndarray, "frame 15"],
    touching: Bool[np.ndarray, "frame 8"],
) -> Corners:
    """Returns how the soles' corners move in one walker's frames."""
    model = env.model.mujoco
    data = mujoco.MjData(model)
    sites = [model.site(name).id for name in CONTACT_SITES]
    speed = np.zeros((len(qpos), len(sites)))
    velocity = np.zeros(6)
    for frame in range(len(qpos)):
        data.qpos[:], data.qvel[:] = qpos[frame][COORDINATE], qvel[frame][COORDINATE]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        for place, site in enumerate(sites):
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, site, velocity, 0)
            speed[frame, place] = np.hypot(velocity[3], velocity[4])
    return Corners(speed, touching)


def _slid(
    corners: Corners, time: Float[np.ndarray, " frame"], contact: Bool[np.ndarray, "frame 2"]
) -> float:
    """Returns how far both soles slid while they bore, m."""
    touching = corners.touching.reshape(-1, 2, 4)
    slowest = np.where(touching, corners.speed.reshape(-1, 2, 4), np.inf).min(axis=2)
    bearing = contact & touching.any(axis=2)
    speed = np.where(bearing, slowest, 0.0).sum(axis=1)
    return float((speed[:-1] * np.diff(time)).sum())


def _share(there: Bool[np.ndarray, " frame"]) -> float:
    return float(there.mean()) if there.size else np.nan
