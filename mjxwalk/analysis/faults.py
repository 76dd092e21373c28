"""What a spatial gait may hide: feet that slide or brush the ground, flight, drift, and a lean.

Measured at the contact points of the feet, the corners of the soles; MuJoCo moves them.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from mjxwalk.analysis.footfalls import find_footfalls, observe
from mjxwalk.analysis.frame import Frame
from mjxwalk.envs import LeggedEnv
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.replay import Recording

FAULTS = ("slip", "brush", "flight", "drift", "pitch_rad", "roll_rad")


class Corners(NamedTuple):
    """How fast the soles' corners move along the ground, and which of them touch it.

    Attributes:
      speed: horizontal, m/s.
      touching: whether each is below the ground.
    """

    speed: Float[np.ndarray, "frame point"]
    touching: Bool[np.ndarray, "frame point"]


def measure_faults(recording: Recording, env: LeggedEnv) -> Frame:
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

    Raises:
      ValueError: the body moves in the plane.
    """
    import pandas as pd

    root = env.anatomy.root
    if root.is_planar:
        raise ValueError(f"{env.anatomy.name} moves in the plane, and these faults are of space")
    feet = [env.anatomy.points_of(leg) for leg in env.anatomy.legs]
    observations = observe(recording, env)
    rows: list[dict[str, Any]] = []
    for walker, footfalls in enumerate(find_footfalls(recording, observations)):
        frames = len(footfalls.time)
        states: Any = recording.states
        qpos = states.qpos[:frames, walker].astype(np.float64)
        qvel = states.qvel[:frames, walker].astype(np.float64)
        corners = corner_speeds(env, qpos, qvel, states.touching[:frames, walker])
        walked = float(qpos[-1, 0] - qpos[0, 0])
        raw: Any = np.stack([corners.touching[:, foot].any(axis=1) for foot in feet], axis=1)
        rows.append(
            {
                "fell": bool(states.trial.fell[-1, walker]),
                "slip": _slid(corners, feet, footfalls.time, footfalls.contact) / walked,
                "brush": _share(raw[~footfalls.contact]),
                "flight": _share(~raw.any(axis=1)),
                "drift": float(qpos[-1, 1] - qpos[0, 1]) / walked,
                "pitch_rad": float(qpos[:, root.pitch].mean()),
                "roll_rad": float(np.abs(qpos[:, root.roll]).mean()),
            }
        )
    return pd.DataFrame(rows)


def corner_speeds(
    env: LeggedEnv,
    qpos: Float[np.ndarray, "frame coordinate"],
    qvel: Float[np.ndarray, "frame coordinate"],
    touching: Bool[np.ndarray, "frame point"],
) -> Corners:
    """Returns how the soles' corners move in one walker's frames."""
    model = env.model.mujoco
    data = mujoco.MjData(model)
    points = env.anatomy.points
    bodies = [int(model.body(point.body).id) for point in points]
    joints = list(env.anatomy.joint_coordinate)
    speed = np.zeros((len(qpos), len(points)))
    velocity = np.zeros(6)
    for frame in range(len(qpos)):
        data.qpos[:], data.qvel[:] = qpos[frame][joints], qvel[frame][joints]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        for place, (body, point) in enumerate(zip(bodies, points, strict=True)):
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, velocity, 0)
            away = data.xmat[body].reshape(3, 3) @ point.offset - (0.0, 0.0, point.radius)
            along = velocity[3:] + np.cross(velocity[:3], away)
            speed[frame, place] = np.hypot(along[0], along[1])
    return Corners(speed, touching)


def _slid(
    corners: Corners,
    feet: list[list[int]],
    time: Float[np.ndarray, " frame"],
    contact: Bool[np.ndarray, "frame 2"],
) -> float:
    """Returns how far both soles slid while they bore, m."""
    speed = np.zeros(len(time))
    for leg, points in enumerate(feet):
        touching = corners.touching[:, points]
        slowest = np.where(touching, corners.speed[:, points], np.inf).min(axis=1)
        bearing = contact[:, leg] & touching.any(axis=1)
        speed += np.where(bearing, slowest, 0.0)
    return float((speed[:-1] * np.diff(time)).sum())


def _share(there: Bool[np.ndarray, " frame"]) -> float:
    return float(there.mean()) if there.size else np.nan
