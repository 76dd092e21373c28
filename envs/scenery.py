"""The ground around walkers that have walked, to be shown."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from mjxwalk.envs.anatomy import Root
from mjxwalk.envs.terrain import Patch, Terrain

BEHIND, AHEAD = 3.0, 8.0  # m of ground before the first and beyond the last place; ours
BESIDE = 0.9  # m of it to either side; ours


class Scenery(NamedTuple):
    """A part of the ground, and how much of it is shown.

    Attributes:
      patch: the ground.
      width: that is shown, m; of several walkers each has its own lane as wide.
    """

    patch: Patch
    width: float

    def height(self, x: float, y: float = 0.0) -> float:
        """Returns the ground's height at a place, m, by linear interpolation."""
        heights, spacing = self.patch.heights, self.patch.spacing
        along = (x - self.patch.x) / spacing
        rows = [np.interp(along, np.arange(heights.shape[1]), row) for row in heights]
        return float(np.interp((y - self.patch.y) / spacing, np.arange(len(rows)), rows))


def around(env: Any, ground: Terrain, qpos: Float[np.ndarray, "*frame coordinate"]) -> Scenery:
    """Returns the ground where walkers get to.

    Args:
      env: a `LeggedEnv`.
      ground: of one walker, as `Trials.given` has it.
      qpos: of the walkers, m and rad.
    """
    root: Root = env.anatomy.root
    x = qpos[..., root.forward]
    y = np.zeros_like(x) if root.sideways is None else qpos[..., root.sideways]
    heights, row, courses = ground
    patch = env.terrain.patch(
        np.asarray(heights)[int(row)],
        (float(x.min()) - BEHIND, float(x.max()) + AHEAD),
        (float(y.min()) - BESIDE, float(y.max()) + BESIDE),
    )
    patch = env.course.on(patch, None if courses is None else np.asarray(courses)[int(row)])
    rows = len(patch.heights)
    # Ground without rows is as wide as walkers drift.
    width = patch.spacing * (rows - 1) if rows > 1 else 2 * (BESIDE + float(np.abs(y).max()))
    return Scenery(patch, width)
