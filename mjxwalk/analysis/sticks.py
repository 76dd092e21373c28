"""Stick figures of a walker at several times, on its terrain, of either body."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure

from mjxwalk import replay
from mjxwalk.analysis import figures
from mjxwalk.envs import Flame


class Sticks(NamedTuple):
    """A walker at several times.

    Attributes:
      skeletons: from `mjxwalk.replay`, x and z of a planar body's joints or x, y and z, m.
      ground_x: where the terrain's nodes are, of a spatial terrain those along its middle, m.
      ground_z: how high they are, m.
    """

    skeletons: Float[np.ndarray, "figure 2 joint axis"]
    ground_x: Float[np.ndarray, " node"]
    ground_z: Float[np.ndarray, " node"]


def find(
    env: Any, qpos: Float[np.ndarray, "figure coordinate"], heights: Float[np.ndarray, "..."]
) -> Sticks:
    """Returns a body in each of some poses.

    Args:
      env: body and ground.
      qpos: coordinates of the body.
      heights: of the one terrain, m.
    """
    ground = env.terrain
    along = ground.start + ground.spacing * np.arange(len(heights))
    if isinstance(env, Flame):
        middle = heights[:, heights.shape[1] // 2]
        return Sticks(replay.spatial_skeleton(env, qpos), along, middle)
    return Sticks(replay.skeleton(env, qpos), along, heights)


def draw(sticks: Sticks) -> Figure:
    """Returns the picture: from the side, and of a spatial body from the front as well.

    Raises:
      ValueError: there is no figure to draw.
    """
    spatial = sticks.skeletons.shape[-1] == 3
    return (figures.spatial_stick_figures if spatial else figures.stick_figures)(*sticks)
