"""A body in C MuJoCo as `mjxwalk verify` steps it: one walker on level ground."""

from typing import Any

import numpy as np

from mjxwalk.envs import LeggedEnv
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.verify import reference

__all__ = ["Reference", "mujoco"]


class Reference:
    """One walker with motors that give torques, on level ground at height zero.

    Attributes:
      torque_cost: of the motors so far, N m s.
    """

    def __init__(self, env: LeggedEnv, qpos: Any, qvel: Any) -> None:
        self._walkers = reference.Reference(env, [qpos], [qvel], env.level_trials())
        self.torque_cost = 0.0

    def step(
        self, torque: Any, target: Any = 0.0, stiffness: Any = 0.0, damping: Any = 0.0
    ) -> None:
        """Moves on by one step."""
        walkers = self._walkers
        parts = (torque, target, stiffness, damping)
        given = walkers.step([np.broadcast_to(part, (1, len(torque))) for part in parts])
        self.torque_cost += walkers.env.timestep * np.abs(given.torque).sum()

    @property
    def data(self) -> Any:
        """The walker's `mujoco.MjData`: where its joints are, and all else as of the last step."""
        walkers = self._walkers
        joints = list(walkers.anatomy.joint_coordinate)
        walkers.herd.qpos[:], walkers.herd.qvel[:] = (
            walkers.qpos[:, joints],
            walkers.qvel[:, joints],
        )
        return walkers.herd.data

    @property
    def stretch(self) -> Any:
        """Of the ground's springs, m: along x in the plane, along x and y in space."""
        stretch = self._walkers.stretch[0]
        return stretch[:, 0] if self._walkers.anatomy.root.is_planar else stretch
