"""Rigid-body dynamics from MJX's pieces, with implicit forces in the mass matrix.

MuJoCo's own contact and constraint solver stays off: the studies apply penalty forces, which need
no data-dependent loop. A force that is taken linearly implicit enters in two parts, a known
generalised force and an inertia that is added before the accelerations are solved for.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs._mujoco import compiled, mjx, mujoco


class Model(NamedTuple):
    """A compiled body: constants only.

    Attributes:
      mujoco: the `mujoco.MjModel`, for names, masses and C MuJoCo.
      mjx: the same model for MJX.
      data: the `mjx.Data` that every step starts from.
    """

    mujoco: Any
    mjx: Any
    data: Any


def compile_model(spec: Any) -> Model:
    """Returns the model of an `mujoco.MjSpec`, with contact and constraint solver off.

    Raises:
      ValueError: MuJoCo cannot compile it.
    """
    disable = mujoco.mjtDisableBit
    spec.option.disableflags |= disable.mjDSBL_CONTACT | disable.mjDSBL_CONSTRAINT
    # MuJoCo's own implicit joint damping would hide what the step does.
    spec.option.disableflags |= disable.mjDSBL_EULERDAMP
    model = compiled(spec)
    data = mujoco.MjData(model)
    with jax.ensure_compile_time_eval():
        return Model(model, mjx.put_model(model), mjx.put_data(model, data))


class PointMass(NamedTuple):
    """A point mass that is fixed to a body.

    Attributes:
      body: its number.
      place: from the body's origin in its axes, m.
      mass: kg.
    """

    body: int
    place: Float[np.ndarray, "3"]
    mass: Float[Array, ""]


def forward(
    model: Model,
    qpos: Float[Array, " nq"],
    qvel: Float[Array, " nv"],
    carried: PointMass | None = None,
) -> Any:
    """Returns `mjx.Data` with positions, velocities and bias forces (gravity, Coriolis).

    Args:
      model: the body.
      qpos: m and rad.
      qvel: m/s and rad/s.
      carried: is part of the body's inertia, but not of `subtree_com`.
    """
    data = model.data.replace(qpos=qpos, qvel=qvel)
    data = mjx.kinematics(model.mjx, data)
    data = with_mass(mjx.com_pos(model.mjx, data), carried)
    data = mjx.com_vel(model.mjx, data)
    return mjx.rne(model.mjx, data)


class PointLoad(NamedTuple):
    """A force on a point of a body, and the point mass that is its implicit part.

    Attributes:
      offset: from the centre of mass of the whole tree to the point, world axes, m.
      force: world axes, N.
      mass: kg.
    """

    offset: Float[Array, "3"]
    force: Float[Array, "3"]
    mass: Float[Array, ""]


def with_mass(data: Any, carried: PointMass | None) -> Any:
    """Returns `mjx.Data` whose inertias have a point mass in them, if there is one."""
    if carried is None:
        return data
    body, place, mass = carried
    offset = point_offset(data, place_of(data, body, place))
    inertia = data._impl.cinert.at[body].add(_point_inertia(offset, mass))
    return data.tree_replace({"_impl.cinert": inertia})


def place_of(data: Any, body: int, place: Float[np.ndarray, "3"]) -> Float[Array, "3"]:
    """Returns where a point of a body is that has a constant place in the body's axes, m."""
    return data.xpos[body] + data.xmat[body] @ place


def point_offset(data: Any, point: Float[Array, "3"]) -> Float[Array, "3"]:
    """Returns where a point lies from the centre of mass that MuJoCo's spatial vectors refer to."""
    return point - data.subtree_com[1]


def point_velocity(data: Any, body: int, offset: Float[Array, "3"]) -> Float[Array, "3"]:
    """Returns the velocity of a point that moves with a body, world axes, m/s."""
    rotation, translation = data.cvel[body, :3], data.cvel[body, 3:]
    return translation + jnp.cross(rotation, offset)


def equations(
    model: Model,
    data: Any,
    generalized_force: Float[Array, " nv"],
    added_inertia: Float[Array, " nv"],
    loads: dict[int, list[PointLoad]],
) -> tuple[Float[Array, "nv nv"], Float[Array, " nv"]]:
    """Returns mass matrix and force whose quotient is qacc, under gravity, forces and point loads.

    Args:
      model: the body.
      data: what `forward` returned.
      generalized_force: N or N m, one for each degree of freedom.
      added_inertia: on the mass matrix's diagonal, kg or kg m^2.
      loads: for each body's id, its loads.
    """
    force = generalized_force - data.qfrc_bias
    inertia = data._impl.cinert
    for body, body_loads in loads.items():
        wrench = jnp.zeros(6)
        for load in body_loads:
            wrench += jnp.concatenate([jnp.cross(load.offset, load.force), load.force])
            inertia = inertia.at[body].add(_point_inertia(load.offset, load.mass))
        force += moves(model.mujoco, body) * (data.cdof @ wrench)
    data = mjx.crb(model.mjx, data.tree_replace({"_impl.cinert": inertia}))
    return mjx.full_m(model.mjx, data) + jnp.diag(added_inertia), force


def coupled(
    mass_matrix: Float[Array, "nv nv"],
    force: Float[Array, " nv"],
    coupling: Float[np.ndarray, "nv coordinate"] | None,
) -> tuple[Float[Array, "coordinate coordinate"], Float[Array, " coordinate"]]:
    """Returns mass matrix and force of fewer, independent coordinates.

    By d'Alembert's principle the coupling projects both, and what couples the joints needs no force
    of its own.

    Args:
      mass_matrix: of the degrees of freedom.
      force: on them, N or N m.
      coupling: qvel as a constant matrix times the rates of the coordinates; None where every
        degree of freedom is independent.
    """
    if coupling is None:
        return mass_matrix, force
    tied = jnp.asarray(coupling)
    return tied.T @ mass_matrix @ tied, tied.T @ force


def solve(matrix: Float[Array, "n n"], right: Float[Array, " n"]) -> Float[Array, " n"]:
    """Returns x of `matrix x = right` for a symmetric, positive definite matrix.

    Gaussian elimination without pivots, last row first: a tree's leaves come last, and eliminating
    them first fills in nothing between its branches. Written out, since LAPACK's batched Cholesky
    waits for ever for XLA's own threads when two CPU devices have some hundred matrices each.
    """
    size = right.shape[0]
    columns, pivots = [], []
    for _ in range(size - 1):
        inverse = 1.0 / matrix[-1, -1]
        column, pivot = matrix[:-1, -1] * inverse, right[-1] * inverse
        # Nothing reads below the diagonal, so an engine that drops what nobody reads halves this.
        matrix = matrix[:-1, :-1] - jnp.outer(column, matrix[:-1, -1])
        right = right[:-1] - column * right[-1]
        columns.append(column)
        pivots.append(pivot)
    solution = right / matrix[0]
    for column, pivot in zip(reversed(columns), reversed(pivots), strict=True):
        solution = jnp.append(solution, pivot - column @ solution)
    return solution


def _point_inertia(offset: Float[Array, "3"], mass: Float[Array, ""]) -> Float[Array, "10"]:
    """Returns a point mass as MuJoCo's spatial inertia: xx yy zz xy xz yz, m x, m y, m z, m."""
    x, y, z = offset
    one = jnp.ones(())
    xx, yy, zz = y * y + z * z, x * x + z * z, x * x + y * y
    return mass * jnp.stack([xx, yy, zz, -x * y, -x * z, -y * z, x, y, z, one])


def moves(m: Any, body: int) -> Float[np.ndarray, " nv"]:
    """Returns 1 for each degree of freedom of a `mujoco.MjModel` that moves the body, else 0."""
    moves = np.zeros(m.nv, np.float32)
    while body:
        first = m.body_dofadr[body]
        moves[first : first + m.body_dofnum[body]] = 1.0
        body = m.body_parentid[body]
    return moves
