"""The `mjx.Data` of a tree: what MJX's collisions, tendons and constraints are computed from.

MJX takes velocities about the tree's centre of mass, and a free root's turning about the root's
axes. Nothing of it reads where the one is or which axes the other are, as long as all agree. Here
they are the root's place and the world's axes, as `Tree` has them.
"""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import frames
from mjxwalk.envs._mujoco import mjx
from mjxwalk.envs.mujoco_law.layout import ROOT, WORLD, Fixed
from mjxwalk.envs.mujoco_law.model import MujocoModel
from mjxwalk.envs.mujoco_law.tree import Tree


def of_tree(
    model: MujocoModel, tree: Tree, qpos: Float[Array, " nq"], rates: Float[Array, " nv"]
) -> Any:
    """Returns the `mjx.Data` with places, motions, velocities, tendons and passive forces.

    Args:
      model: of the body.
      tree: where it is.
      qpos: positions.
      rates: of the degrees of freedom, as `Tree` counts them.
    """
    ours, found = model.mjx, model.mujoco
    data = model.data.replace(qpos=qpos, qvel=rates)
    if found.neq:
        data = mjx.kinematics(ours, data)  # a weld reads quaternions
    own = np.arange(found.nbody)
    xpos, xmat = _placed(tree, own, np.zeros((found.nbody, 3)), None)
    xipos, ximat = _placed(tree, own, found.body_ipos, found.body_iquat)
    geom_xpos, geom_xmat = _placed(tree, found.geom_bodyid, found.geom_pos, found.geom_quat)
    data = data.replace(
        xpos=xpos,
        xmat=xmat,
        xipos=xipos,
        ximat=ximat,
        geom_xpos=geom_xpos,
        geom_xmat=geom_xmat,
        subtree_com=jnp.broadcast_to(tree.origin, (found.nbody, 3)),
        cdof=tree.motions,
    )
    if found.nsite:
        site_xpos, site_xmat = _placed(tree, found.site_bodyid, found.site_pos, found.site_quat)
        data = data.replace(site_xpos=site_xpos, site_xmat=site_xmat)
    data = mjx.com_vel(ours, mjx.tendon(ours, data))
    speeds = data._impl.ten_J @ rates
    return mjx.passive(ours, data.tree_replace({"_impl.ten_velocity": speeds}))


def about_centre(model: MujocoModel, data: Any) -> Any:
    """Returns the `mjx.Data` with velocities and inertias about the tree's centre of mass.

    Motions of degrees of freedom are not known there.

    Args:
      model: of the body.
      data: from `of_tree`.
    """
    moved = mjx.com_pos(model.mjx, data)
    offset = moved.subtree_com[ROOT] - data.subtree_com[ROOT]
    turning, moving = data.cvel[:, :3], data.cvel[:, 3:]
    seen = moving + jnp.cross(turning, offset)
    return moved.replace(cvel=jnp.concatenate([turning, seen], axis=1))


def _placed(
    tree: Tree, bodies: Any, places: Float[np.ndarray, "each 3"], quats: Any
) -> tuple[Float[Array, "each 3"], Float[Array, "each 3 3"]]:
    """Returns where in the world things are, m, and their axes as columns.

    Args:
      tree: where it is.
      bodies: number of the body of each.
      places: from the body's origin in its axes, m.
      quats: by which each is turned in them; None for not at all.
    """
    found, axes = [], []
    for each, body in enumerate(bodies):
        fixed = tree.layout.bodies[int(body)]
        own = frames.matrix(fixed.quat)
        offset = frames.clean(fixed.place + own @ places[each])
        turn = own if quats is None else own @ frames.matrix(quats[each])
        place, frame = _of_link(tree, fixed)
        found.append(place + frames.along(frame, offset))
        turned = [frames.along(frame, axis) for axis in frames.clean(turn).T]
        axes.append(jnp.stack(turned, axis=1))
    return jnp.stack(found), jnp.stack(axes)


def _of_link(tree: Tree, fixed: Fixed) -> tuple[Float[Array, "3"], frames.Frame]:
    """Returns the point and axes of the link, or of the world, that a body is fixed to."""
    if fixed.link == WORLD:
        return jnp.zeros_like(tree.origin), frames.identity()
    x, y, z = tree.turns[fixed.link].T
    return tree.origin + tree.places[fixed.link], (x, y, z)
