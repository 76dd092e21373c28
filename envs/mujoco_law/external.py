"""What contacts do to each body of a state, as MuJoCo's `cfrc_ext` tells it."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import dynamics
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mujoco_law import report, softness
from mjxwalk.envs.mujoco_law.forward import Forward
from mjxwalk.envs.mujoco_law.ground import Touches
from mjxwalk.envs.mujoco_law.model import MujocoModel
from mjxwalk.envs.mujoco_law.own_pairs import OwnPairs, Slots

_PYRAMIDAL = int(mujoco.mjtCone.mjCONE_PYRAMIDAL)
_WITHOUT_TURNING = 3  # dimension of a contact with friction along the ground alone


def wrenches(model: MujocoModel, now: Forward) -> Float[Array, "body 6"]:
    """Returns torque and force of all contacts on each body, about the tree's centre of mass.

    Axes are the world's, units N m and N. Those of the world itself are zero.

    Raises:
      ValueError: a contact has friction against turning, or a body is tied to another.
    """
    found = jnp.zeros((model.mujoco.nbody, 6), now.force.dtype)
    if model.mujoco.neq:
        raise ValueError("forces of <equality> are not told; remove them")
    for contacts, touches, pushes in report.of_ground(model, now.touches, now.solution.force):
        _check(contacts.dim)
        for point, body in enumerate(contacts.body):
            found = found.at[int(body)].add(_wrench(now.data, touches.place[point], pushes[point]))
    for pairs, slots, touches, pushes in report.of_own_pairs(model, now):
        _check(pairs.softness.dim)
        found = found + _of_slots(model, now, pairs, slots, touches, pushes)
    contact = now.data._impl.contact
    for dim in sorted({int(each) for each in contact.dim}):
        _check(dim)
        places = np.flatnonzero(contact.dim == dim)
        pushes = jnp.stack([_own_push(model, now, int(place), dim) for place in places])
        turned = jax.vmap(functools.partial(_wrench, now.data))(contact.pos[places], pushes)
        # Where geoms are numbered, MJX has arrays that are not known while a step is traced.
        bodies = jnp.asarray(model.mujoco.geom_bodyid)[contact.geom[places]]
        found = found.at[bodies[:, 0]].add(-turned).at[bodies[:, 1]].add(turned)
    return found.at[0].set(0.0)


def _of_slots(
    model: MujocoModel,
    now: Forward,
    pairs: OwnPairs,
    slots: Slots,
    touches: Touches,
    pushes: Float[Array, "slot 3"],
) -> Float[Array, "body 6"]:
    """Returns torque and force of pairs that touch on each body."""

    def compute() -> Any:
        sides = np.eye(model.mujoco.nbody)[pairs.bodies]  # pair, end, body
        sign = jax.vmap(lambda pair: softness.picked(sides[:, 1] - sides[:, 0], pair))(slots.pair)
        turned = jax.vmap(functools.partial(_wrench, now.data))(touches.place, pushes)
        return sign.T @ turned

    shape = model.mujoco.nbody, 6
    return jax.lax.cond(jnp.any(slots.filled), compute, lambda: jnp.zeros(shape, now.force.dtype))


def _own_push(model: MujocoModel, now: Forward, place: int, dim: int) -> Float[Array, "3"]:
    """Returns a contact's force on the second of two geoms of the body, world axes, N."""
    contact = now.data._impl.contact
    first = int(contact.efc_address[place])
    if dim == 1:
        return now.solution.force[first] * contact.frame[place][0]
    if int(model.mujoco.opt.cone) != _PYRAMIDAL:
        axes = now.solution.force[first : first + dim]
        return axes @ contact.frame[place][:dim]
    edges = now.solution.force[first : first + 2 * (dim - 1)].reshape(-1, 2)
    along = contact.friction[place][: dim - 1] * (edges[:, 0] - edges[:, 1])
    return edges.sum() * contact.frame[place][0] + along @ contact.frame[place][1:dim]


def _wrench(data: Any, place: Float[Array, "3"], push: Float[Array, "3"]) -> Float[Array, "6"]:
    return jnp.concatenate([jnp.cross(dynamics.point_offset(data, place), push), push])


def _check(dim: int) -> None:
    if dim > _WITHOUT_TURNING:
        raise ValueError(f"forces of contacts of condim {dim} are not told; write condim 3")


def of_motors(model: MujocoModel, now: Forward) -> Float[Array, " nv"]:
    """Returns what motors do to each degree of freedom, N m."""
    return jnp.zeros_like(now.force).at[np.asarray(model.driven)].add(now.torque)
