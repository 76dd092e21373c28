"""Contacts as rows of MuJoCo's constraints."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mujoco_law.constraints import Cones, Rows
from mjxwalk.envs.mujoco_law.ground import Touches
from mjxwalk.envs.mujoco_law.softness import Softness

_TINY = float(mujoco.mjMINVAL)


def num(dim: int, *, pyramidal: bool) -> int:
    """Returns how many rows a contact has."""
    return 2 * (dim - 1) if dim > 1 and pyramidal else dim


def rows(softness: Softness, touches: Touches, model: Any, data: Any, *, pyramidal: bool) -> Rows:
    """Returns the constraints of contacts, each after the other.

    A contact has a row for its normal alone, the edges of a pyramid, which lean to either side of
    the normal along each axis of friction, or the axes of an elliptic cone.
    """
    axes = _jacobian(softness, touches, data)
    velocity = axes @ data.qvel
    friction = jnp.asarray(softness.friction, axes.dtype)
    if touches.under.friction is not None:
        friction = friction * touches.under.friction[:, None]
    stiffness, damping = (
        jnp.asarray(each, axes.dtype) for each in (softness.stiffness, softness.damping)
    )
    if touches.under.stiffness is not None:
        stiffness = stiffness * touches.under.stiffness
        damping = damping * touches.under.stiffness[:, None]
    impedance = _impedance(softness, touches)
    push = stiffness * impedance * (touches.distance - softness.margin)
    if softness.dim == 1 or not pyramidal:
        return _plain(softness, touches, model, axes, velocity, friction, damping, impedance, push)
    inverse = jnp.asarray(softness.inverse, axes.dtype)
    leaning = friction[:, :, None] * jnp.array([1.0, -1.0], axes.dtype)  # point axis side
    edges = axes[:, :1, None] + leaning[..., None] * axes[:, 1:, None]
    speeds = velocity[:, :1, None] + leaning * velocity[:, 1:, None]
    target = -damping[:, 0, None, None] * speeds - push[:, None, None]
    along = friction[:, 0] ** 2
    regular = inverse * (1.0 + along) * 2.0 * along / float(model.opt.impratio)
    weight = _weight(regular, impedance, touches)
    each = num(softness.dim, pyramidal=True)
    size = len(weight) * each
    zero = jnp.zeros(size, axes.dtype)
    return Rows(
        edges.reshape(size, -1),
        jnp.repeat(weight, each),
        target.reshape(size),
        zero,
        zero + jnp.inf,
    )


def _plain(
    softness: Softness,
    touches: Touches,
    model: Any,
    axes: Float[Array, "point axis dof"],
    velocity: Float[Array, "point axis"],
    friction: Float[Array, "point direction"],
    damping: Float[Array, "point 2"],
    impedance: Float[Array, " point"],
    push: Float[Array, " point"],
) -> Rows:
    """Returns a row for each axis of each contact, which form a cone if there are several."""
    size, dim = velocity.shape
    sliding = jnp.repeat(damping[:, 1:], dim - 1, axis=1)
    target = -jnp.concatenate([damping[:, :1], sliding], axis=1) * velocity
    target = target.at[:, 0].add(-push)
    inverse = jnp.asarray(softness.inverse, axes.dtype)[:, None]
    # Friction yields in proportion to what it can hold.
    along = inverse / float(model.opt.impratio) * (friction[:, :1] / friction) ** 2
    regular = jnp.concatenate([inverse, along], axis=1)
    weight = _weight(regular, impedance[:, None], touches)
    zero = jnp.zeros(size * dim, velocity.dtype)
    cones: tuple[Cones, ...] = ()
    if dim > 1:
        ratio = friction[:, :1] / np.sqrt(model.opt.impratio)
        places = np.arange(size * dim).reshape(size, dim)
        cones = (Cones(places, jnp.concatenate([ratio, friction], axis=1)),)
    return Rows(
        axes.reshape(size * dim, -1),
        weight.reshape(size * dim),
        target.reshape(size * dim),
        zero,
        zero + jnp.inf,
        cones,
    )


def _jacobian(softness: Softness, touches: Touches, data: Any) -> Float[Array, "point axis dof"]:
    """Returns the velocity along the normal and friction's axes of each degree of freedom."""

    def one(place: Array, frame: Array, moves: Array) -> Array:
        offset = place - data.subtree_com[1]
        turning = data.cdof[:, :3] * moves[:, None]
        moving = (data.cdof[:, 3:] + jnp.cross(data.cdof[:, :3], offset)) * moves[:, None]
        found = frame @ moving.T
        if softness.dim > 3:
            found = jnp.concatenate([found, frame @ turning.T])
        return found[: softness.dim]

    moves = jnp.asarray(softness.moves, data.qvel.dtype)
    return jax.vmap(one)(touches.place, touches.frame, moves)


def _impedance(softness: Softness, touches: Touches) -> Float[Array, " point"]:
    """Returns the share of a contact's force that its bodies feel, which grows with depth."""
    least, most, width, middle, power = softness.impedance.T
    deep = jnp.minimum(jnp.abs(touches.distance - softness.margin) / width, 1.0)
    below = deep**power / middle ** (power - 1.0)
    above = 1.0 - (1.0 - deep) ** power / (1.0 - middle) ** (power - 1.0)
    return least + jnp.where(deep < middle, below, above) * (most - least)


def _weight(
    inverse: Float[Array, "point ..."], impedance: Float[Array, "point ..."], touches: Touches
) -> Float[Array, "point ..."]:
    """Returns the inverse of the rows' regularisation; 0 of points that do not touch."""
    regular = jnp.maximum(inverse * (1.0 - impedance) / impedance, _TINY)
    touching = touches.touching if regular.ndim == 1 else touches.touching[:, None]
    return jnp.where(touching, 1.0 / regular, 0.0)
