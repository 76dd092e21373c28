"""MuJoCo's constraints as rows: what they push, and how that falls as they are met.

A row's velocity along its constraint is to change at a rate `target`; its cost is half of
`weight` times the square of what is missing, linear beyond the forces that the row can give. Rows
of an elliptic cone have a cost together.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

TINY = 1e-15  # as MuJoCo's own smallest number


class Rows(NamedTuple):
    """Constraints of one step.

    Attributes:
      jacobian: from velocities of the degrees of freedom to those along each row.
      weight: inverse of each row's regularisation, kg or kg m^2; 0 of a row that does nothing.
      target: acceleration along each row, m/s^2 or rad/s^2.
      lowest: force that a row gives at least, N or N m.
      highest: force that a row gives at most, N or N m.
      cones: of the rows that form elliptic cones, those of each dimension.
    """

    jacobian: Float[Array, "row dof"]
    weight: Float[Array, " row"]
    target: Float[Array, " row"]
    lowest: Float[Array, " row"]
    highest: Float[Array, " row"]
    cones: tuple["Cones", ...] = ()


class Cones(NamedTuple):
    """Contacts whose friction is limited by an elliptic cone, all of one dimension.

    Attributes:
      rows: of each contact, the normal one first.
      friction: of each row of a contact; of the normal one that of the regularised cone.
    """

    rows: Int[np.ndarray, "contact axis"]
    friction: Float[Array, "contact axis"]


class Part(NamedTuple):
    """Constraints that are computed together.

    Attributes:
      make: returns their rows.
      present: whether one of them may do anything, else nothing of them need be computed; None
        where they are computed anyhow. Rows that may be absent only push.
    """

    make: Callable[[], Rows]
    present: Bool[Array, ""] | None = None


class Law(NamedTuple):
    """Forces of all rows, and how they fall as what is missing grows."""

    force: Float[Array, " row"]
    weight: Float[Array, " row"]
    blocks: tuple[Float[Array, "contact axis axis"], ...]


def kept(part: Part) -> Part:
    """Returns a part whose rows are computed once; without cones."""

    def compute() -> Any:
        rows = part.make()
        return rows.jacobian, rows.weight, rows.target

    jacobian, weight, target = when(part, compute)
    lowest, highest = jnp.zeros_like(weight), jnp.full_like(weight, jnp.inf)
    return part._replace(make=lambda: Rows(jacobian, weight, target, lowest, highest))


def when(part: Part, compute: Callable[[], Any]) -> Any:
    """Returns what is computed of a part, or zeros if it is absent."""
    if part.present is None:
        return compute()
    shapes = jax.eval_shape(compute)
    return jax.lax.cond(
        part.present,
        compute,
        lambda: jax.tree.map(lambda each: jnp.zeros(each.shape, each.dtype), shapes),
    )


def law_of(rows: Rows, missing: Float[Array, " row"]) -> Law:
    """Returns the forces for what is missing of each row's target."""
    wanted = -rows.weight * missing
    force = jnp.clip(wanted, rows.lowest, rows.highest)
    weight = jnp.where(wanted == force, rows.weight, 0.0)
    blocks: list[Array] = []
    for cones in rows.cones:
        own = rows.weight[cones.rows]
        pushed, falls = jax.vmap(_cone)(missing[cones.rows], own, cones.friction)
        force = force.at[cones.rows].set(pushed)
        weight = weight.at[cones.rows].set(0.0)
        blocks.append(falls)
    return Law(force, weight, tuple(blocks))


def _cone(
    missing: Float[Array, " axis"], weight: Float[Array, " axis"], friction: Float[Array, " axis"]
) -> tuple[Float[Array, " axis"], Float[Array, "axis axis"]]:
    """Returns one contact's force, and the matrix by which it falls as what is missing grows.

    Within the cone a contact pulls back by its rows' weights; where it would leave the cone it
    slips, and its cost is that of the distance from the cone; where it separates it does nothing.
    """
    scaled = missing * friction
    ratio, normal = friction[0], scaled[0]
    square = jnp.sum(scaled[1:] ** 2)
    across = jnp.sqrt(jnp.maximum(square, TINY))
    sticks = ratio * normal + across <= 0.0
    slips = ~sticks & (normal < ratio * across)
    stiffness = weight[0] / (ratio**2 * (1.0 + ratio**2))
    beyond = normal - ratio * across
    direction = scaled[1:] / across
    change = jnp.concatenate([jnp.ones(1), -ratio * direction]) * friction  # of `beyond`
    sliding = -stiffness * beyond * change
    # The second derivative of `beyond` is that of the length of the tangential part.
    bend = jnp.diag(friction[1:] ** 2) - jnp.outer(
        direction * friction[1:], direction * friction[1:]
    )
    falls = stiffness * jnp.outer(change, change)
    falls = falls.at[1:, 1:].add(-stiffness * beyond * ratio / across * bend)
    zero = jnp.zeros_like(missing)
    force = jnp.where(sticks, -weight * missing, jnp.where(slips, sliding, zero))
    inside = jnp.diag(weight)
    return force, jnp.where(sticks, inside, jnp.where(slips, falls, 0.0))


def weighted(rows: Rows, law: Law, values: Float[Array, "row ..."]) -> Float[Array, "row ..."]:
    """Returns by how much the rows' forces fall for a change of what is missing."""
    each = law.weight if values.ndim == 1 else law.weight[:, None]
    found = each * values
    for cones, block in zip(rows.cones, law.blocks, strict=True):
        found = found.at[cones.rows].set(jnp.einsum("cij,cj...->ci...", block, values[cones.rows]))
    return found
