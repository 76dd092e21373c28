"""Contacts with the ground as rows of MuJoCo's constraints."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import dynamics
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mujoco_law.ground import GroundContacts, Touches
from mjxwalk.envs.mujoco_law.solver import Cones, Rows

_REFSAFE = int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)
_LEAST_IMPEDANCE, _MOST_IMPEDANCE = float(mujoco.mjMINIMP), float(mujoco.mjMAXIMP)
_TINY = float(mujoco.mjMINVAL)


def rows(
    contacts: GroundContacts, touches: Touches, model: Any, data: Any, *, pyramidal: bool
) -> Rows:
    """Returns the constraints of contacts, each after the other.

    A contact has a row for its normal alone, the edges of a pyramid, which lean to either side of
    the normal along each axis of friction, or the axes of an elliptic cone.
    """
    dim = contacts.dim
    axes = _jacobian(contacts, touches, model, data)
    velocity = axes @ data.qvel
    friction = jnp.asarray(contacts.friction[:, : dim - 1], axes.dtype)
    if touches.under.friction is not None:
        friction = friction * touches.under.friction[:, None]
    stiffness, damping, impedance = _reference(contacts, contacts.solref, touches, model)
    inverse = _inverse_weight(contacts, model, axes.dtype)
    push = stiffness * impedance * (touches.distance - contacts.margin)
    if dim == 1 or not pyramidal:
        return _plain(contacts, touches, model, axes, velocity, friction, impedance, push)
    leaning = friction[:, :, None] * jnp.array([1.0, -1.0], axes.dtype)  # point axis side
    edges = axes[:, :1, None] + leaning[..., None] * axes[:, 1:, None]
    speeds = velocity[:, :1, None] + leaning * velocity[:, 1:, None]
    target = -damping[:, None, None] * speeds - push[:, None, None]
    along = friction[:, 0] ** 2
    regular = inverse * (1.0 + along) * 2.0 * along / float(model.opt.impratio)
    weight = _weight(regular, impedance, touches)
    num = 2 * (dim - 1)
    size = len(contacts.geom) * num
    zero = jnp.zeros(size, axes.dtype)
    return Rows(
        edges.reshape(size, -1),
        jnp.repeat(weight, num),
        target.reshape(size),
        zero,
        zero + jnp.inf,
    )


def _plain(
    contacts: GroundContacts,
    touches: Touches,
    model: Any,
    axes: Float[Array, "point axis dof"],
    velocity: Float[Array, "point axis"],
    friction: Float[Array, "point direction"],
    impedance: Float[Array, " point"],
    push: Float[Array, " point"],
) -> Rows:
    """Returns a row for each axis of each contact, which form a cone if there are several."""
    num, dim = velocity.shape
    normal = _reference(contacts, contacts.solref, touches, model)[1][:, None]
    own = contacts.solreffriction.any(1, keepdims=True)
    solref = np.where(own, contacts.solreffriction, contacts.solref)
    sliding = _reference(contacts, solref, touches, model)[1][:, None]
    damping = jnp.concatenate([normal, jnp.repeat(sliding, dim - 1, axis=1)], axis=1)
    target = -damping * velocity
    target = target.at[:, 0].add(-push)
    inverse = _inverse_weight(contacts, model, velocity.dtype)[:, None]
    # Friction yields in proportion to what it can hold.
    along = inverse / float(model.opt.impratio) * (friction[:, :1] / friction) ** 2
    regular = jnp.concatenate([jnp.broadcast_to(inverse, (num, 1)), along], axis=1)
    weight = _weight(regular, impedance[:, None], touches)
    zero = jnp.zeros(num * dim, velocity.dtype)
    cones: tuple[Cones, ...] = ()
    if dim > 1:
        ratio = friction[:, :1] / np.sqrt(model.opt.impratio)
        places = np.arange(num * dim).reshape(num, dim)
        cones = (Cones(places, jnp.concatenate([ratio, friction], axis=1)),)
    return Rows(
        axes.reshape(num * dim, -1),
        weight.reshape(num * dim),
        target.reshape(num * dim),
        zero,
        zero + jnp.inf,
        cones,
    )


def _jacobian(
    contacts: GroundContacts, touches: Touches, model: Any, data: Any
) -> Float[Array, "point axis dof"]:
    """Returns the velocity along the normal and friction's axes of each degree of freedom."""
    moves = np.stack([dynamics.moves(model, int(body)) for body in contacts.body])

    def one(place: Array, frame: Array, moves: Array) -> Array:
        offset = place - data.subtree_com[1]
        turning = data.cdof[:, :3] * moves[:, None]
        moving = (data.cdof[:, 3:] + jnp.cross(data.cdof[:, :3], offset)) * moves[:, None]
        found = frame @ moving.T
        if contacts.dim > 3:
            found = jnp.concatenate([found, frame @ turning.T])
        return found[: contacts.dim]

    return jax.vmap(one)(touches.place, touches.frame, jnp.asarray(moves, data.qvel.dtype))


def _reference(
    contacts: GroundContacts, solref: Any, touches: Touches, model: Any
) -> tuple[Float[Array, " point"], Float[Array, " point"], Float[Array, " point"]]:
    """Returns stiffness, 1/s^2, damping, 1/s, and impedance, as MuJoCo's documentation has them.

    https://mujoco.readthedocs.io/en/stable/modeling.html#solver-parameters
    """
    least, most, width, middle, power = contacts.solimp.T
    least = np.clip(least, _LEAST_IMPEDANCE, _MOST_IMPEDANCE)
    most = np.clip(most, _LEAST_IMPEDANCE, _MOST_IMPEDANCE)
    middle = np.clip(middle, _LEAST_IMPEDANCE, _MOST_IMPEDANCE)
    width, power = np.maximum(width, _TINY), np.maximum(power, 1.0)
    time, ratio = solref.T
    if not int(model.opt.disableflags) & _REFSAFE:
        time = np.where(time > 0.0, np.maximum(time, 2.0 * model.opt.timestep), time)
    with np.errstate(divide="ignore", invalid="ignore"):
        standard = time > 0.0
        stiffness = np.where(standard, 1.0 / (most * time * ratio) ** 2, -solref[:, 0] / most**2)
        damping = np.where(standard, 2.0 / (most * time), -solref[:, 1] / most)
    distance = touches.distance - contacts.margin
    deep = jnp.minimum(jnp.abs(distance) / width, 1.0)
    below = deep**power / middle ** (power - 1.0)
    above = 1.0 - (1.0 - deep) ** power / (1.0 - middle) ** (power - 1.0)
    impedance = least + jnp.where(deep < middle, below, above) * (most - least)
    found = [jnp.asarray(each, distance.dtype) for each in (stiffness, damping)]
    if touches.under.stiffness is not None:
        found = [each * touches.under.stiffness for each in found]
    return found[0], found[1], impedance


def _inverse_weight(contacts: GroundContacts, model: Any, dtype: Any) -> Float[Array, " point"]:
    """Returns how far a body yields to a force at rest, as MuJoCo estimates it, 1/kg."""
    return jnp.asarray(np.asarray(model.body_invweight0)[contacts.body, 0], dtype)


def _weight(
    inverse: Float[Array, "point ..."], impedance: Float[Array, "point ..."], touches: Touches
) -> Float[Array, "point ..."]:
    """Returns the inverse of the rows' regularisation; 0 of points that do not touch."""
    regular = jnp.maximum(inverse * (1.0 - impedance) / impedance, _TINY)
    touching = touches.touching if regular.ndim == 1 else touches.touching[:, None]
    return jnp.where(touching, 1.0 / regular, 0.0)
