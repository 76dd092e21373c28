"""The planar body in C MuJoCo as `mjxwalk verify` steps it: one walker on level ground."""

from typing import Any

import numpy as np

from mjxwalk.envs import Action, Planar7
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.verify.bodies import Walkers

__all__ = ["Reference", "mujoco"]


class Reference:
    """One walker on level ground at height zero."""

    def __init__(self, env: Planar7, qpos: Any, qvel: Any) -> None:
        self._walkers = Walkers(env, [qpos], [qvel], np.zeros((1, env.terrain.num_nodes)))

    def step(self, torque: Any) -> None:
        """Moves on by one step."""
        given: Any = np.asarray(torque)[None]
        nothing: Any = np.zeros((1, 6))
        self._walkers.step(Action(given, nothing, nothing, nothing))

    @property
    def data(self) -> Any:
        """The walker's `mujoco.MjData`."""
        return self._walkers.data

    @property
    def stretch(self) -> Any:
        """Of the ground's springs, m."""
        return self._walkers.stretch[0, :, 0]
