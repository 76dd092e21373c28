"""What moves a tree of links without constraints: its mass matrix and the forces it takes.

Accelerations here are those of points that move with a link, not spatial vectors: a link that turns
with angular velocity w and gains angular acceleration a accelerates a point at r from its own by
W r, where W = [a] + [w] [w] and [v] is the matrix of the cross product. It costs the least.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import frames
from mjxwalk.envs.dynamics import PointMass
from mjxwalk.envs.mujoco_law.layout import BALL, FREE, SLIDE, WORLD, Joint
from mjxwalk.envs.mujoco_law.tree import Tree

Matrix = Float[Array, "3 3"]
_SAME = 1e-9  # share by which moments of inertia may differ that are taken for equal


class Masses(NamedTuple):
    """Where the masses of links are, about the root's place in the world's axes.

    Attributes:
      mass: of each link, kg.
      centre: of mass, m.
      spread: second moments of mass about the centre, kg m^2.
    """

    mass: Float[Array, " link"]
    centre: Float[Array, "link 3"]
    spread: Float[Array, "link 3 3"]


def masses(tree: Tree) -> Masses:
    """Returns where the masses of links are."""
    inertias = [link.inertia for link in tree.layout.links]
    centres: list[Array] = []
    spreads: list[Array] = []
    for turn, place, inertia in zip(tree.turns, tree.places, inertias, strict=True):
        x, y, z = turn.T
        centres.append(place + frames.along((x, y, z), inertia.centre))
        axes = [frames.along((x, y, z), axis) for axis in inertia.axes.T]
        # The sum of outer products of axes is 1, which saves one, or two where moments are equal.
        moments = [float(moment) for moment in inertia.moments]
        base = max(moments, key=lambda each: sum(_alike(each, other) for other in moments))
        spread = base * jnp.eye(3)
        for axis, moment in zip(axes, moments, strict=True):
            if not _alike(moment, base):
                spread = spread + ((moment - base) * axis[:, None]) * axis
        spreads.append(spread)
    mass = jnp.asarray(np.array([each.mass for each in inertias]), tree.places.dtype)
    return Masses(mass, jnp.stack(centres), jnp.stack(spreads))


def with_mass(tree: Tree, masses: Masses, carried: PointMass) -> Masses:
    """Returns where the masses of links are with a point mass that a body carries."""
    fixed = tree.layout.bodies[carried.body]
    place = fixed.place + frames.matrix(fixed.quat) @ carried.place
    there = tree.places[fixed.link] + tree.turns[fixed.link] @ place
    mass, centre = masses.mass[fixed.link], masses.centre[fixed.link]
    total, apart = mass + carried.mass, there - centre
    share = carried.mass / total
    return Masses(
        masses.mass.at[fixed.link].set(total),
        masses.centre.at[fixed.link].set(centre + share * apart),
        masses.spread.at[fixed.link].add(mass * share * apart[:, None] * apart),
    )


def gather(tree: Tree, wrenches: list[Array]) -> Float[Array, " dof"]:
    """Returns the forces on degrees of freedom, of torque and force on each link."""
    totals = list(wrenches)
    found: list[Array] = [jnp.zeros(())] * tree.motions.shape[0]
    for number in reversed(range(len(totals))):
        link = tree.layout.links[number]
        for joint in link.joints:
            for dof in _dofs(joint):
                found[dof] = tree.motions[dof] @ totals[number]
        if link.parent != WORLD:
            totals[link.parent] = totals[link.parent] + totals[number]
    return jnp.stack(found)


def force_of_motion(
    tree: Tree,
    mass: Masses,
    rates: Float[Array, " dof"],
    gains: Float[Array, " dof"],
    gravity: Float[np.ndarray, "3"],
) -> Float[Array, " dof"]:
    """Returns the forces on degrees of freedom under which their rates gain as much, by gravity.

    Args:
      tree: where it is.
      mass: of its links.
      rates: of the degrees of freedom.
      gains: accelerations of them.
      gravity: m/s^2.
    """
    start = jnp.asarray(-gravity, tree.places.dtype)
    found: list[_Moving] = []
    wrenches: list[Array] = []
    for number, link in enumerate(tree.layout.links):
        at = _Moving(jnp.zeros(3), jnp.zeros(3), None, start)
        if link.parent != WORLD:
            at = found[link.parent]
        for joint, step in zip(link.joints, tree.steps[number], strict=True):
            at = _moved(tree, joint, step, at, rates, gains)
        at = at._replace(matrix=_matrix(at))
        found.append(at)
        wrenches.append(_wrench(tree, mass, number, at))
    return gather(tree, wrenches)


class _Moving(NamedTuple):
    """How a link moves.

    Attributes:
      rate: angular velocity, rad/s.
      gain: angular acceleration, rad/s^2.
      matrix: by which points gain velocity that move with the link; None where nothing turns.
      point: acceleration of the link's point less that of free fall, m/s^2.
    """

    rate: Float[Array, "3"]
    gain: Float[Array, "3"]
    matrix: Matrix | None
    point: Float[Array, "3"]


def _moved(
    tree: Tree,
    joint: Joint,
    step: Float[Array, "3"],
    at: _Moving,
    rates: Float[Array, " dof"],
    gains: Float[Array, " dof"],
) -> _Moving:
    """Returns how what lies behind a joint moves."""
    dof = joint.dof
    if joint.kind == FREE:
        return _Moving(rates[dof + 3 : dof + 6], gains[dof + 3 : dof + 6], None,
                       at.point + gains[dof : dof + 3])  # fmt: skip
    point = at.point if at.matrix is None else at.point + at.matrix @ step
    if joint.kind == SLIDE:
        axis = tree.motions[dof, 3:]
        turned = 2.0 * jnp.cross(at.rate, axis * rates[dof])
        return at._replace(point=point + axis * gains[dof] + turned)
    own = [(tree.motions[each, :3], each) for each in _dofs(joint)]
    rate = sum((axis * rates[each] for axis, each in own), start=jnp.zeros(3))
    gain = sum((axis * gains[each] for axis, each in own), start=jnp.cross(at.rate, rate))
    turning = _Moving(at.rate + rate, at.gain + gain, None, point)
    return turning._replace(matrix=_matrix(turning))


def _matrix(at: _Moving) -> Matrix:
    x, y, z = at.rate
    a, b, c = at.gain
    xx, yy, zz = x * x, y * y, z * z
    xy, xz, yz = x * y, x * z, y * z
    return jnp.stack(
        [
            jnp.stack([-(yy + zz), xy - c, xz + b]),
            jnp.stack([xy + c, -(xx + zz), yz - a]),
            jnp.stack([xz - b, yz + a, -(xx + yy)]),
        ]
    )


def _wrench(tree: Tree, mass: Masses, number: int, at: _Moving) -> Float[Array, "6"]:
    """Returns torque and force that move a link as it does."""
    assert at.matrix is not None
    centre = mass.centre[number]
    force = mass.mass[number] * (at.point + at.matrix @ (centre - tree.places[number]))
    # The sum of r x W r over all masses.
    moments = at.matrix @ mass.spread[number]
    torque = jnp.stack(
        [
            moments[2, 1] - moments[1, 2],
            moments[0, 2] - moments[2, 0],
            moments[1, 0] - moments[0, 1],
        ]
    )
    return jnp.concatenate([torque + jnp.cross(centre, force), force])


def mass_matrix(tree: Tree, mass: Masses) -> Float[Array, "dof dof"]:
    """Returns the mass matrix, without what joints have of their own."""
    size = tree.motions.shape[0]
    matrix = jnp.zeros((size, size))
    total: list[_Composite | None] = [None] * len(tree.layout.links)
    for number in reversed(range(len(total))):
        link = tree.layout.links[number]
        own = _composite(mass, number)
        before = total[number]
        whole = own if before is None else _Composite(*jax.tree.map(jnp.add, own, before))
        if link.parent != WORLD:
            so_far = total[link.parent]
            total[link.parent] = (
                whole if so_far is None else _Composite(*jax.tree.map(jnp.add, so_far, whole))
            )
        for joint in link.joints:
            for dof in _dofs(joint):
                pushed = whole.times(tree.motions[dof])
                matrix = _with_row(matrix, tree, link.dofs, dof, pushed)
    return matrix


def _with_row(
    matrix: Float[Array, "dof dof"],
    tree: Tree,
    dofs: tuple[int, ...],
    dof: int,
    pushed: Float[Array, "6"],
) -> Float[Array, "dof dof"]:
    """Returns a matrix with what a freedom's motion asks of those before it, on both sides."""
    before = np.array(dofs[: dofs.index(dof) + 1])
    row = tree.motions[before] @ pushed
    return matrix.at[dof, before].add(row).at[before[:-1], dof].add(row[:-1])


class _Composite(NamedTuple):
    """Inertia of a link and of all that it carries, about the root's place."""

    mass: Float[Array, ""]
    first: Float[Array, "3"]  # moments of mass
    second: Matrix

    def times(self, motion: Float[Array, "6"]) -> Float[Array, "6"]:
        """Returns angular and linear momentum of a motion."""
        turning, moving = motion[:3], motion[3:]
        inertia = jnp.trace(self.second) * jnp.eye(3) - self.second
        return jnp.concatenate(
            [
                inertia @ turning + jnp.cross(self.first, moving),
                self.mass * moving + jnp.cross(turning, self.first),
            ]
        )


def _composite(mass: Masses, number: int) -> _Composite:
    first = mass.mass[number] * mass.centre[number]
    return _Composite(
        mass.mass[number], first, mass.spread[number] + first[:, None] * mass.centre[number]
    )


def _dofs(joint: Joint) -> range:
    num = {FREE: 6, BALL: 3}.get(joint.kind, 1)
    return range(joint.dof, joint.dof + num)


def _alike(one: float, other: float) -> bool:
    return abs(one - other) < _SAME * max(abs(one), abs(other))
