"""MuJoCo's constraints solved by Newton's method: accelerations and forces of one step.

MuJoCo defines the accelerations of a step as those that minimise a convex function: half the square
of their distance from the unconstrained ones, measured by the mass matrix, plus a cost of each
constraint (https://mujoco.readthedocs.io/en/stable/computation/index.html#constraint-model). Who
minimises it gets MuJoCo's result, by whatever way. This way does little: what is zero in a tree's
mass matrix stays zero, nothing is computed twice for both triangles of a matrix, and a step's
length is found by derivatives alone, which float32 tells apart better than costs.

A row's velocity along its constraint is to change at a rate `target`; its cost is half of
`weight` times the square of what is missing, linear beyond the forces that the row can give. Rows
of an elliptic cone have a cost together.
"""

from collections.abc import Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from mjxwalk.envs import dynamics

TINY = 1e-15  # as MuJoCo's own smallest number
MOST_WRITTEN_OUT = 8  # iterations of the line search; ours: more are a loop that may end early


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


class Solution(NamedTuple):
    """What the constraints do.

    Attributes:
      qacc: accelerations.
      force: of each row, N or N m.
      joint_force: the same on the degrees of freedom.
    """

    qacc: Float[Array, " dof"]
    force: Float[Array, " row"]
    joint_force: Float[Array, " dof"]


class _Law(NamedTuple):
    """Forces of all rows, and how they fall as what is missing grows."""

    force: Float[Array, " row"]
    weight: Float[Array, " row"]
    blocks: tuple[Float[Array, "contact axis axis"], ...]


class _Iterate(NamedTuple):
    qacc: Float[Array, " dof"]
    inertial: Float[Array, " dof"]  # mass matrix times qacc
    missing: Float[Array, " row"]  # jacobian times qacc, less the target
    gain: Float[Array, ""]  # of the last iteration
    iterations: Int[Array, ""]


class _Bracket(NamedTuple):
    length: Float[Array, ""]
    low: Float[Array, ""]
    high: Float[Array, ""]
    change: Float[Array, ""]  # of the length, by the last iteration
    iterations: Int[Array, ""]


def solve(
    mass: Float[Array, "dof dof"],
    force: Float[Array, " dof"],
    rows: Rows,
    start: Float[Array, " dof"],
    *,
    iterations: int,
    ls_iterations: int,
    tolerance: float = 0.0,
) -> Solution:
    """Returns accelerations and constraint forces.

    Args:
      mass: matrix of the degrees of freedom.
      force: on them, without constraints.
      rows: the constraints.
      start: accelerations to start from; those of the last step are near.
      iterations: at most.
      ls_iterations: on the length of each iteration's step.
      tolerance: gain, over the mass matrix's trace, below which an iteration is the last one.
    """
    # ours: no smaller gains can be told apart.
    least = max(float(jnp.finfo(mass.dtype).eps), tolerance) * jnp.trace(mass)

    def iterate(at: _Iterate) -> _Iterate:
        law = _law(rows, at.missing)
        downhill = force - at.inertial + rows.jacobian.T @ law.force
        curvature = mass + rows.jacobian.T @ _weighted(rows, law, rows.jacobian)
        step = dynamics.solve(curvature, downhill)
        gain = step @ downhill
        inertial, along = mass @ step, rows.jacobian @ step
        slope = step @ (at.inertial - force), step @ inertial
        length = _length(rows, at.missing, along, slope, ls_iterations)
        return _Iterate(
            at.qacc + length * step,
            at.inertial + length * inertial,
            at.missing + length * along,
            gain,
            at.iterations + 1,
        )

    at = _Iterate(
        start,
        mass @ start,
        rows.jacobian @ start - rows.target,
        jnp.asarray(jnp.inf, start.dtype),
        jnp.zeros((), jnp.int32),
    )
    if iterations == 1:
        at = iterate(at)
    else:
        at = jax.lax.while_loop(
            lambda at: (at.iterations < iterations) & (at.gain > least), iterate, at
        )
    found = _law(rows, at.missing).force
    return Solution(at.qacc, found, rows.jacobian.T @ found)


def _length(
    rows: Rows,
    missing: Float[Array, " row"],
    along: Float[Array, " row"],
    slope: tuple[Float[Array, ""], Float[Array, ""]],
    iterations: int,
) -> Float[Array, ""]:
    """Returns how much of a step to take: where the cost's derivative along it is zero.

    The derivative rises. Newton's method on it stays in the bracket that it has found so far.

    Args:
      rows: the constraints.
      missing: of each row before the step.
      along: change of `missing` over the whole step.
      slope: derivative of the inertial part of the cost at the step's begin, and its change.
      iterations: of the method.
    """
    first, rise = slope

    def closer(at: _Bracket) -> _Bracket:
        length = at.length
        law = _law(rows, missing + length * along)
        derivative = first + length * rise - law.force @ along
        second = rise + along @ _weighted(rows, law, along)
        short = derivative <= 0.0
        low = jnp.where(short, length, at.low)
        high = jnp.where(short, at.high, length)
        better = length - derivative / jnp.maximum(second, TINY)
        within = (better >= low) & (better <= high)
        # Out of the bracket it is closed: an open one lets all greater lengths in.
        better = jnp.where(within, better, 0.5 * (low + jnp.minimum(high, 2.0 * low + 2.0)))
        return _Bracket(better, low, high, jnp.abs(better - length), at.iterations + 1)

    one, never = jnp.ones_like(first), jnp.full_like(first, jnp.inf)
    at = _Bracket(one, jnp.zeros_like(first), never, never, jnp.zeros((), jnp.int32))
    if iterations > MOST_WRITTEN_OUT:
        # ours: a cost is flat about its least, so that half of the digits do for the length.
        share = float(jnp.finfo(first.dtype).eps) ** 0.5
        return jax.lax.while_loop(
            lambda at: (at.iterations < iterations) & (at.change > share * at.length), closer, at
        ).length
    for _ in range(iterations):
        at = closer(at)
    return at.length


def _law(rows: Rows, missing: Float[Array, " row"]) -> _Law:
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
    return _Law(force, weight, tuple(blocks))


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


def _weighted(rows: Rows, law: _Law, values: Float[Array, "row ..."]) -> Float[Array, "row ..."]:
    """Returns by how much the rows' forces fall for a change of what is missing."""
    each = law.weight if values.ndim == 1 else law.weight[:, None]
    found = each * values
    for cones, block in zip(rows.cones, law.blocks, strict=True):
        found = found.at[cones.rows].set(jnp.einsum("cij,cj...->ci...", block, values[cones.rows]))
    return found


def joined(parts: Sequence[Rows]) -> Rows:
    """Returns the rows of several, one after the other."""
    cones: list[Cones] = []
    first = 0
    for part in parts:
        cones += [each._replace(rows=each.rows + first) for each in part.cones]
        first += part.weight.shape[0]
    each = zip(*(part[:-1] for part in parts), strict=True)
    return Rows(*(jnp.concatenate(values) for values in each), cones=tuple(cones))
