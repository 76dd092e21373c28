"""Single pictures of a walker on its ground."""

from typing import Any

import numpy as np
from jaxtyping import Float, UInt8

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.pictures import camera, offscreen, scene

REACH = 110.0  # m; ours: farther than any trial


class Still:
    """Draws one walker after the other; another ground makes another model."""

    def __init__(self, env: Any, size: tuple[int, int]) -> None:
        self._env, self._size = env, size
        self._heights: Any = None
        self._model: Any = None
        self._painter: Any = None

    def picture(
        self, heights: Float[np.ndarray, "*node"], qpos: Float[np.ndarray, " coordinate"]
    ) -> UInt8[np.ndarray, "down across 3"]:
        """Returns a picture of a walker.

        Raises:
          RunError: there is no OpenGL.
        """
        if self._heights is None or not np.array_equal(heights, self._heights):
            self.close()
            # The whole ground, wherever the walker will get to.
            reach = np.zeros((2, len(qpos)))
            reach[1, self._env.anatomy.root.forward] = REACH
            self._model = scene.build(self._env, heights, reach, self._size)
            self._painter, self._heights = offscreen.Painter(self._model, self._size), heights
        data = mujoco.MjData(self._model)
        data.qpos[:] = scene.joint_positions(self._env, qpos[None])[0]
        mujoco.mj_forward(self._model, data)
        view = camera.beside(self._env, self._model)
        view.lookat[:] = data.body(self._env.anatomy.torso).xpos
        return self._painter.draw(data, view)

    def close(self) -> None:
        """Gives OpenGL back."""
        if self._painter is not None:
            self._painter.__exit__()
            self._painter = None
