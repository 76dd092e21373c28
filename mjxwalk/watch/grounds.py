"""The ground around the walkers, as plain data for the page."""

from typing import Any

import msgspec
import numpy as np
from jaxtyping import Float

from mjxwalk.envs.reil_trials import NAMES, TrialVariation
from mjxwalk.envs.surface import SerpentineWalk

BEHIND, AHEAD = 3.0, 8.0  # m of ground before the first and beyond the last place; ours
BESIDE = 0.9  # m of it to either side; ours


class Ground(msgspec.Struct, frozen=True, kw_only=True):
    """Where the nodes of the heights are; along x is the series' last axis.

    Attributes:
      x: of the first node, m.
      y: of the first row of nodes, m; a planar body's ground has one row.
      spacing: of the nodes, m.
      rows: across.
      width: that is drawn of it, m; of several walkers each has its own lane as wide.
    """

    x: float
    y: float
    spacing: float
    rows: int
    width: float


def around(
    terrain: Any, heights: Float[np.ndarray, "*node"], qpos: Float[np.ndarray, "frame walker _"]
) -> tuple[Ground, Float[np.ndarray, "row place"]]:
    """Returns the ground where walkers get to, and its heights, m."""
    if isinstance(terrain, TrialVariation):
        return _slope(terrain, heights, qpos)
    step = terrain.spacing
    first = int(np.floor((qpos[..., 0].min() - BEHIND - terrain.start) / step))
    last = int(np.ceil((qpos[..., 0].max() + AHEAD - terrain.start) / step))
    along = np.clip(np.arange(first, last + 1), 0, heights.shape[0] - 1)  # the ends go on level
    x = terrain.start + step * first
    if not isinstance(terrain, SerpentineWalk):
        ground = Ground(x=x, y=0.0, spacing=step, rows=1, width=2 * BESIDE)
        return ground, heights[along][None]
    middle = 0.5 * (heights.shape[1] - 1)
    low = int(np.floor((qpos[..., 1].min() - BESIDE) / step + middle))
    high = int(np.ceil((qpos[..., 1].max() + BESIDE) / step + middle))
    rows = np.arange(low, high + 1)
    period = 2 * (heights.shape[1] - 1)
    across = np.abs(rows - period * np.rint(rows / period)).astype(int)  # goes on mirrored
    ground = Ground(
        x=x, y=step * (low - middle), spacing=step, rows=len(rows), width=step * (len(rows) - 1)
    )
    return ground, heights[np.ix_(along, across)].T


def _slope(
    terrain: TrialVariation, draws: Any, qpos: Any
) -> tuple[Ground, Float[np.ndarray, "row place"]]:
    """Returns a plane that rises along x as the trial drew it."""
    first, last = np.floor(qpos[..., 0].min() - BEHIND), np.ceil(qpos[..., 0].max() + AHEAD)
    along = np.arange(first, last + 1)
    rise = terrain.slope * float(draws[NAMES.index("slope")])
    reach = BESIDE + float(np.abs(qpos[..., 1]).max())  # it drifts by metres
    ground = Ground(x=float(first), y=0.0, spacing=1.0, rows=1, width=2 * reach)
    return ground, (rise * along)[None]


def height(ground: Ground, rows: Float[np.ndarray, "row place"], qpos: Any) -> float:
    """Returns the ground's height under the hips, m, by linear interpolation.

    Args:
      ground: from `around`.
      rows: likewise.
      qpos: of the walker, which begins with x and, in space, y.
    """
    along = (float(qpos[0]) - ground.x) / ground.spacing
    each = [np.interp(along, np.arange(rows.shape[1]), row) for row in rows]
    across = (float(qpos[1]) - ground.y) / ground.spacing
    return float(np.interp(across, np.arange(len(each)), each))
