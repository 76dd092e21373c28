"""Stick figures of a walker at several times, on its ground."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure

from mjxwalk.analysis import figures
from mjxwalk.envs import LeggedEnv, Terrain, scenery
from mjxwalk.envs._mujoco import mujoco


class Sticks(NamedTuple):
    """A walker at several times.

    Attributes:
      skeletons: from `skeleton`, m.
      ground_x: where the ground's nodes are along the walker's way, m.
      ground_z: how high they are, m.
      spatial: whether the body moves in space.
    """

    skeletons: Float[np.ndarray, "figure leg joint 3"]
    ground_x: Float[np.ndarray, " node"]
    ground_z: Float[np.ndarray, " node"]
    spatial: bool


def find(
    env: LeggedEnv,
    qpos: Float[np.ndarray, "figure coordinate"],
    ground: Terrain,
) -> Sticks:
    """Returns a body in each of some poses.

    Args:
      env: body and ground.
      qpos: coordinates of the body.
      ground: that it walks on.
    """
    patch, _ = scenery.around(env, ground, qpos)
    along = patch.x + patch.spacing * np.arange(patch.heights.shape[1])
    row = int(np.clip(round(-patch.y / patch.spacing), 0, len(patch.heights) - 1))
    spatial = not env.anatomy.root.is_planar
    return Sticks(skeleton(env, qpos), along, patch.heights[row], spatial)


def skeleton(
    env: LeggedEnv, qpos: Float[np.ndarray, "frame coordinate"]
) -> Float[np.ndarray, "frame leg joint 3"]:
    """Returns where the joints of a body are, in one walker's frames.

    For each leg, x, y and z of the torso's top, then of each of its bodies from the torso to the
    foot, whose origin is the ankle, and of heel, toe and ankle again, m.
    """
    model, anatomy = env.model.mujoco, env.anatomy
    data, joints = mujoco.MjData(model), list(anatomy.joint_coordinate)
    torso = model.body(anatomy.torso).id
    chains = [_chain(model, torso, model.body(leg.foot).id) for leg in anatomy.legs]
    longest = max(map(len, chains))
    chains = [[torso] * (longest - len(chain)) + chain for chain in chains]
    # As far above the centre of the upper body as that is above the hips.
    top = 2.0 * _centre(model, torso, chains) * (0.0, 0.0, 1.0)
    feet = [anatomy.heel_and_toe(leg) for leg in anatomy.legs]
    below = np.array([0.0, 0.0, anatomy.points[0].radius])  # a sphere's lowest point touches
    figures: list[Any] = []
    for coordinates in np.asarray(qpos, np.float64):
        data.qpos[:] = coordinates[joints]
        mujoco.mj_kinematics(model, data)
        turned = data.xmat.reshape(-1, 3, 3)
        head = data.xpos[torso] + turned[torso] @ top
        legs: list[Any] = []
        for chain, ends in zip(chains, feet, strict=True):
            ankle = chain[-1]
            heel, toe = (data.xpos[ankle] + turned[ankle] @ end - below for end in ends)
            legs.append([head, *data.xpos[chain], heel, toe, data.xpos[ankle].copy()])
        figures.append(legs)
    return np.array(figures)


def draw(sticks: Sticks) -> Figure:
    """Returns the picture: from the side, and of a spatial body from the front as well.

    Raises:
      ValueError: there is no figure to draw.
    """
    given = sticks.skeletons, sticks.ground_x, sticks.ground_z
    if sticks.spatial:
        return figures.spatial_stick_figures(*given)
    return figures.stick_figures(*given)


def _centre(model: Any, torso: int, chains: list[list[int]]) -> Float[np.ndarray, "3"]:
    """Returns the centre of mass of all that is not part of a leg, in the torso's axes, m."""
    legs = {body for chain in chains for body in chain if body != torso}
    upper: list[int] = []
    for body in range(1, model.nbody):
        if model.body_parentid[body] in legs:
            legs.add(body)
        if body not in legs:
            upper.append(body)
    if upper == [torso] or not model.body_mass[upper].any():
        return model.body_ipos[torso].copy()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    centre = np.average(data.xipos[upper], axis=0, weights=model.body_mass[upper])
    return data.xmat[torso].reshape(3, 3).T @ (centre - data.xpos[torso])


def _chain(model: Any, torso: int, foot: int) -> list[int]:
    """Returns the bodies from the torso to a foot."""
    chain = [foot]
    while chain[-1] != torso:
        chain.append(int(model.body_parentid[chain[-1]]))
    return chain[::-1]
