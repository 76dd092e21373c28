"""Single pictures of a walker on its ground."""

from typing import Any

import numpy as np
from jaxtyping import Float, UInt8

from mjxwalk.envs import Terrain
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.pictures import camera, offscreen, scene

REACH = 110.0  # m; ours: farther than any trial


class Still:
    """Draws one walker after the other; another ground makes another model."""

    def __init__(self, env: Any, size: tuple[int, int]) -> None:
        self._env, self._size = env, size
        self._drawn: Any = None
        self._model: Any = None
        self._painter: Any = None

    def picture(
        self, ground: Terrain, qpos: Float[np.ndarray, " coordinate"]
    ) -> UInt8[np.ndarray, "down across 3"]:
        """Returns a picture of a walker.

        Raises:
          RunError: there is no OpenGL.
        """
        tables = [table for table in (ground.heights, ground.course) if table is not None]
        drawn = [np.asarray(table)[int(ground.row)] for table in tables]
        if self._drawn is None or not all(map(np.array_equal, drawn, self._drawn)):
            self.close()
            # The whole ground, wherever the walker will get to.
            reach = np.zeros((2, len(qpos)))
            reach[1, self._env.anatomy.root.forward] = REACH
            self._model = scene.build(self._env, ground, reach, self._size)
            self._painter, self._drawn = offscreen.Painter(self._model, self._size), drawn
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
