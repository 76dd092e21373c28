"""MuJoCo's constraints solved by Newton's method: accelerations and forces of one step.

MuJoCo defines the accelerations of a step as those that minimise a convex function: half the square
of their distance from the unconstrained ones, measured by the mass matrix, plus a cost of each
constraint (https://mujoco.readthedocs.io/en/stable/computation/index.html#constraint-model). Who
minimises it gets MuJoCo's result, by whatever way. This way does little: what is zero in a tree's
mass matrix stays zero, nothing is computed twice for both triangles of a matrix, and a step's
length is found by derivatives alone, which float32 tells apart better than costs.
"""

import functools
from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from mjxwalk.envs import dynamics
from mjxwalk.envs.mujoco_law.constraints import TINY, Cones, Part, Rows, law_of, weighted, when

MOST_WRITTEN_OUT = 8  # iterations of the line search; ours: more are a loop that may end early


class Solution(NamedTuple):
    """What the constraints do.

    Attributes:
      qacc: accelerations.
      force: of each row, part after part, N or N m.
      joint_force: the same on the degrees of freedom.
    """

    qacc: Float[Array, " dof"]
    force: Float[Array, " row"]
    joint_force: Float[Array, " dof"]


class _Iterate(NamedTuple):
    qacc: Float[Array, " dof"]
    inertial: Float[Array, " dof"]  # mass matrix times qacc
    missing: tuple[Array, ...]  # jacobian times qacc, less the target
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
    parts: Sequence[Part],
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
      parts: the constraints.
      start: accelerations to start from; those of the last step are near.
      iterations: at most.
      ls_iterations: on the length of each iteration's step.
      tolerance: gain, over the mass matrix's trace, below which an iteration is the last one.
    """
    # ours: no smaller gains can be told apart.
    least = max(float(jnp.finfo(mass.dtype).eps), tolerance) * jnp.trace(mass)
    begun = [_begun(part, start) for part in parts]
    rows = [each for each, _ in begun]

    def iterate(at: _Iterate) -> _Iterate:
        step, gain = _step(mass, force - at.inertial, parts, rows, at.missing)
        inertial = mass @ step
        along = [when(part, lambda part=part: part.make().jacobian @ step) for part in parts]
        slope = step @ (at.inertial - force), step @ inertial
        length = _length(parts, rows, at.missing, along, slope, ls_iterations)
        return _Iterate(
            at.qacc + length * step,
            at.inertial + length * inertial,
            tuple(now + length * each for now, each in zip(at.missing, along, strict=True)),
            gain,
            at.iterations + 1,
        )

    at = _Iterate(
        start,
        mass @ start,
        tuple(missing for _, missing in begun),
        jnp.asarray(jnp.inf, start.dtype),
        jnp.zeros((), jnp.int32),
    )
    if iterations == 1:
        at = iterate(at)
    else:
        at = jax.lax.while_loop(
            lambda at: (at.iterations < iterations) & (at.gain > least), iterate, at
        )
    found = [law_of(each, missing).force for each, missing in zip(rows, at.missing, strict=True)]
    return Solution(at.qacc, jnp.concatenate(found), _on_joints(parts, found, start))


def _on_joints(
    parts: Sequence[Part], forces: Sequence[Array], like: Float[Array, " dof"]
) -> Float[Array, " dof"]:
    """Returns the forces of all rows on the degrees of freedom, N or N m."""
    return sum(
        (
            when(part, lambda part=part, each=each: part.make().jacobian.T @ each)
            for part, each in zip(parts, forces, strict=True)
        ),
        start=jnp.zeros_like(like),
    )


def _begun(part: Part, start: Float[Array, " dof"]) -> tuple[Rows, Float[Array, " row"]]:
    """Returns a part's rows, without a Jacobian or target, and what each misses at first."""
    places: list[Int[np.ndarray, "contact axis"]] = []

    def compute() -> Any:
        rows = part.make()
        places[:] = [each.rows for each in rows.cones]
        limits = (rows.lowest, rows.highest) if part.present is None else ()
        friction = [each.friction for each in rows.cones]
        return rows.weight, limits, friction, rows.jacobian @ start - rows.target

    weight, limits, friction, missing = when(part, compute)
    if part.present is not None:
        limits = jnp.zeros_like(weight), jnp.full_like(weight, jnp.inf)
    nothing = jnp.zeros(0, weight.dtype)
    cones = tuple(Cones(*each) for each in zip(places, friction, strict=True))
    return Rows(nothing, weight, nothing, *limits, cones=cones), missing


def _step(
    mass: Float[Array, "dof dof"],
    rest: Float[Array, " dof"],
    parts: Sequence[Part],
    rows: Sequence[Rows],
    missing: Sequence[Array],
) -> tuple[Float[Array, " dof"], Float[Array, ""]]:
    """Returns a step of Newton's method, and the gain that it promises.

    Args:
      mass: matrix of the degrees of freedom.
      rest: force without constraints that does not go into accelerations.
      parts: the constraints.
      rows: of the parts, without Jacobians.
      missing: of each row.
    """

    size = rest.shape[0]
    upper = np.triu_indices(size)  # the solution reads no more
    curvature, downhill = mass, rest
    for part, own, each in zip(parts, rows, missing, strict=True):

        def compute(part: Part = part, own: Rows = own, each: Any = each) -> tuple[Array, Array]:
            law, jacobian = law_of(own, each), part.make().jacobian
            pull = jacobian.T @ weighted(own, law, jacobian)
            return pull[upper], jacobian.T @ law.force

        pull, push = when(part, compute)
        curvature += jnp.zeros((size, size), pull.dtype).at[upper].set(pull)
        downhill += push
    step = dynamics.solve(curvature, downhill)
    return step, step @ downhill


def _length(
    parts: Sequence[Part],
    rows: Sequence[Rows],
    missing: Sequence[Array],
    along: Sequence[Array],
    slope: tuple[Float[Array, ""], Float[Array, ""]],
    iterations: int,
) -> Float[Array, ""]:
    """Returns how much of a step to take: where the cost's derivative along it is zero.

    The derivative rises. Newton's method on it stays in the bracket that it has found so far.

    Args:
      parts: the constraints.
      rows: of the parts, without Jacobians.
      missing: of each row before the step.
      along: change of `missing` over the whole step.
      slope: derivative of the inertial part of the cost at the step's begin, and its change.
      iterations: of the method.
    """
    first, rise = slope

    def slopes(each: int, length: Float[Array, ""]) -> tuple[Array, Array]:
        law = law_of(rows[each], missing[each] + length * along[each])
        return law.force @ along[each], along[each] @ weighted(rows[each], law, along[each])

    def closer(at: _Bracket) -> _Bracket:
        length = at.length
        derivative, second = first + length * rise, rise
        for each, part in enumerate(parts):
            push, fall = when(part, functools.partial(slopes, each, length))
            derivative, second = derivative - push, second + fall
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
