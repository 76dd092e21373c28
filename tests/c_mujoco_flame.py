"""The spatial body in C MuJoCo as `mjxwalk verify` steps it: one walker on level ground."""

from typing import Any

import numpy as np

from mjxwalk.envs import Action, Flame
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.verify.bodies import Walkers

__all__ = ["LEFT", "TIE", "Reference", "mujoco"]

LEFT = [*range(6), 6, 7, 8, 9, 10, 12, 13, 14, 15]  # joints whose values are the coordinates
TIE = np.insert(np.eye(15), 11, np.eye(15)[6], axis=0)  # both adductions follow coordinate 6


class Reference:
    """One walker on level ground at height zero, with the hips tied."""

    def __init__(self, env: Flame, qpos: Any, qvel: Any) -> None:
        self._walkers = Walkers(env, [qpos], [qvel], np.zeros((1, *env.terrain.num_nodes)))
        self._timestep = env.timestep
        self.torque_cost = 0.0

    def step(self, torque: Any, target: Any, stiffness: Any, damping: Any) -> None:
        """Moves on by one step."""
        parts: Any = (part[None] for part in (torque, target, stiffness, damping))
        given = self._walkers.step(Action(*parts)).torque
        self.torque_cost += self._timestep * np.abs(given).sum()

    @property
    def data(self) -> Any:
        """The walker's `mujoco.MjData`."""
        return self._walkers.data

    @property
    def stretch(self) -> Any:
        """Of the ground's springs, m."""
        return self._walkers.stretch[0]
