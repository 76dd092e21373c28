"""What the ground does to the feet in a step under MuJoCo's contacts."""

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.mujoco_law import ground, rows
from mjxwalk.envs.mujoco_law import softness as softnesses
from mjxwalk.envs.mujoco_law.forward import Forward
from mjxwalk.envs.mujoco_law.ground import GroundContacts, Touches
from mjxwalk.envs.mujoco_law.model import MujocoModel
from mjxwalk.envs.mujoco_law.own_pairs import OwnPairs, Slots
from mjxwalk.envs.mujoco_law.softness import Softness

_PYRAMIDAL = int(mujoco.mjtCone.mjCONE_PYRAMIDAL)


class Report(NamedTuple):
    """What happened at the begin of a step.

    Attributes:
      touching: whether each leg's foot touches the ground.
      force: of the ground on each leg's foot, world axes, N.
      torque: of each motor, N m.
      foot: where each leg's foot is from the root's origin, world axes, m.
    """

    touching: Bool[Array, " leg"]
    force: Float[Array, "leg 3"]
    torque: Float[Array, " motor"]
    foot: Float[Array, "leg 3"]


def nothing(model: MujocoModel) -> Report:
    """Returns the report of a step in which nothing happened."""
    legs = len(model.feet)
    touching, force = jnp.zeros(legs, bool), jnp.zeros((legs, 3))
    return Report(touching, force, jnp.zeros(len(model.lowest)), force)


def of_feet(
    model: MujocoModel,
    data: Any,
    touched: tuple[Touches, ...],
    pushed: Float[Array, " row"],
    torque: Float[Array, " motor"],
) -> Report:
    """Returns what happened.

    Args:
      model: of the body.
      data: the `mjx.Data` with the places of bodies.
      touched: how the ground is touched, as `model.ground` has it.
      pushed: forces of all constraints, the ground's last, N.
      torque: of the motors, N m.
    """
    places = data.xpos
    foot = jnp.stack([places[bodies[0]] - places[1] for bodies in model.feet])
    touching = [jnp.zeros((), bool) for _ in model.feet]
    force = [jnp.zeros(3) for _ in model.feet]
    for contacts, touches, pushes in of_ground(model, touched, pushed):
        for leg, bodies in enumerate(model.feet):
            own = np.flatnonzero(np.isin(contacts.body, bodies))
            if own.size:
                touching[leg] |= jnp.any(touches.touching[own])
                force[leg] += pushes[own].sum(0)
    return Report(jnp.stack(touching), jnp.stack(force), torque, foot)


def of_ground(
    model: MujocoModel, touched: tuple[Touches, ...], pushed: Float[Array, " row"]
) -> list[tuple[GroundContacts, Touches, Float[Array, "point 3"]]]:
    """Returns the ground's force on each point of contacts of each dimension, world axes, N.

    Args:
      model: of the body.
      touched: how the ground is touched, as `model.ground` has it.
      pushed: forces of all constraints, the ground's last, N.
    """
    start = pushed.shape[0] - sum(_num_rows(model, each) for each in model.ground)
    found: list[tuple[GroundContacts, Touches, Array]] = []
    for contacts, touches in zip(model.ground, touched, strict=True):
        end = start + _num_rows(model, contacts)
        found.append((contacts, touches, _pushes(model, contacts, touches, pushed[start:end])))
        start = end
    return found


def of_own_pairs(
    model: MujocoModel, now: Forward
) -> list[tuple[OwnPairs, Slots, Touches, Float[Array, "slot 3"]]]:
    """Returns the force on the second geom of each slot's pair, world axes, N."""
    pyramidal = int(model.mujoco.opt.cone) == _PYRAMIDAL
    pushed = now.solution.force
    start = pushed.shape[0] - sum(_num_rows(model, each) for each in model.ground)
    found: list[tuple[OwnPairs, Slots, Touches, Array]] = []
    for pairs, slots, touches in reversed(now.own):
        softness = softnesses.of_numbers(pairs.softness, slots.pair)
        each = rows.num(softness.dim, pyramidal=pyramidal)
        end, start = start, start - each * slots.pair.shape[0]
        force = pushed[start:end].reshape(-1, each)
        found.append((pairs, slots, touches, _of_rows(softness, touches, force, pyramidal)))
    return found


def _num_rows(model: MujocoModel, contacts: GroundContacts) -> int:
    pyramidal = int(model.mujoco.opt.cone) == _PYRAMIDAL
    return len(contacts.geom) * rows.num(contacts.dim, pyramidal=pyramidal)


def _pushes(
    model: MujocoModel, contacts: GroundContacts, touches: Touches, force: Float[Array, " row"]
) -> Float[Array, "point 3"]:
    """Returns the ground's force on each point, world axes, N."""
    pyramidal = int(model.mujoco.opt.cone) == _PYRAMIDAL
    softness = ground.softness_of(contacts, model.mujoco)
    return _of_rows(softness, touches, force.reshape(len(contacts.geom), -1), pyramidal)


def _of_rows(
    softness: Softness, touches: Touches, each: Float[Array, "point row"], pyramidal: bool
) -> Float[Array, "point 3"]:
    """Returns the force of the rows of each contact, world axes, N."""
    num, axes = len(each), min(softness.dim, 3) - 1  # of friction along the surface
    if softness.dim > 1 and pyramidal:
        # The edges of a pyramid lean to either side, by friction's coefficient.
        edges = each.reshape(num, -1, 2)
        friction = jnp.asarray(softness.friction[:, :axes], each.dtype)
        if touches.under.friction is not None:
            friction = friction * touches.under.friction[:, None]
        along = friction * (edges[:, :axes, 0] - edges[:, :axes, 1])
        each = jnp.concatenate([edges.sum((1, 2))[:, None], along], axis=1)
    return jnp.einsum("pa,pax->px", each[:, : axes + 1], touches.frame[:, : axes + 1])
