"""How contacts yield, as MuJoCo's documentation has it: what is constant of it.

https://mujoco.readthedocs.io/en/stable/modeling.html#solver-parameters
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from mjxwalk.envs import dynamics
from mjxwalk.envs._mujoco import mujoco

_REFSAFE = int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)
_LEAST_IMPEDANCE, _MOST_IMPEDANCE = float(mujoco.mjMINIMP), float(mujoco.mjMAXIMP)
_TINY = float(mujoco.mjMINVAL)


_Numbers = Array | np.ndarray


class Softness(NamedTuple):
    """What of contacts of one dimension is constant.

    Attributes:
      dim: 1 without friction; 3 with friction along the surface; 4 and 6 also against turning.
      margin: distance below which they touch, m.
      friction: coefficient of each axis of friction.
      stiffness: 1/s^2.
      damping: of the normal and of friction, 1/s.
      impedance: MuJoCo's five numbers.
      inverse: how far both bodies yield to a force at rest, as MuJoCo estimates it, 1/kg.
      moves: 1 where a degree of freedom moves the second body, -1 where it moves the first, else 0.
    """

    dim: int
    margin: Float[_Numbers, " contact"]
    friction: Float[_Numbers, "contact axis"]
    stiffness: Float[_Numbers, " contact"]
    damping: Float[_Numbers, "contact 2"]
    impedance: Float[_Numbers, "contact 5"]
    inverse: Float[_Numbers, " contact"]
    moves: Float[_Numbers, "contact dof"]


def of_contacts(
    model: Any,
    dim: int,
    bodies: Int[np.ndarray, "contact 2"],
    margin: Float[np.ndarray, " contact"],
    friction: Float[np.ndarray, "contact 5"],
    solref: Float[np.ndarray, "contact 2"],
    solreffriction: Float[np.ndarray, "contact 2"],
    solimp: Float[np.ndarray, "contact 5"],
) -> Softness:
    """Returns what is constant of contacts between two bodies each, as NumPy's arrays.

    Args:
      model: the `mujoco.MjModel`.
      dim: of the contacts.
      bodies: numbers of both; the world's is 0.
      margin: as MuJoCo has it.
      friction: along two axes, of turning, and of rolling about two axes.
      solref: MuJoCo's stiffness and damping.
      solreffriction: the same of friction; zeros for that of the normal.
      solimp: MuJoCo's impedance.
    """
    least, most, width, middle, power = solimp.T
    least, most, middle = (
        np.clip(each, _LEAST_IMPEDANCE, _MOST_IMPEDANCE) for each in (least, most, middle)
    )
    width, power = np.maximum(width, _TINY), np.maximum(power, 1.0)
    sliding = np.where(solreffriction.any(1, keepdims=True), solreffriction, solref)
    stiffness, normal = _reference(model, solref, most)
    inverse = np.asarray(model.body_invweight0)[:, 0]
    moves = np.stack([dynamics.moves(model, body) for body in range(model.nbody)])
    return Softness(
        dim=dim,
        margin=margin,
        friction=friction[:, : dim - 1],
        stiffness=stiffness,
        damping=np.stack([normal, _reference(model, sliding, most)[1]], axis=1),
        impedance=np.stack([least, most, width, middle, power], axis=1),
        inverse=inverse[bodies].sum(1),
        moves=moves[bodies[:, 1]] - moves[bodies[:, 0]],
    )


def _reference(
    model: Any, solref: Float[np.ndarray, "contact 2"], most: Float[np.ndarray, " contact"]
) -> tuple[Float[np.ndarray, " contact"], Float[np.ndarray, " contact"]]:
    """Returns stiffness, 1/s^2, and damping, 1/s."""
    time, ratio = solref.T
    if not int(model.opt.disableflags) & _REFSAFE:
        time = np.where(time > 0.0, np.maximum(time, 2.0 * model.opt.timestep), time)
    with np.errstate(divide="ignore", invalid="ignore"):
        standard = time > 0.0
        stiffness = np.where(standard, 1.0 / (most * time * ratio) ** 2, -solref[:, 0] / most**2)
        damping = np.where(standard, 2.0 / (most * time), -solref[:, 1] / most)
    return stiffness, damping


def picked(table: Float[np.ndarray, "contact ..."], number: Int[Array, ""]) -> Any:
    """Returns a row of a table of constants; a constant itself if all rows are the same."""
    table = np.asarray(table)
    if (table == table[:1]).all():
        return table[0]
    # Columns without a choice stay constants, which costs nothing.
    columns = [
        column[0] if (column == column[0]).all() else jnp.asarray(column, float)[number]
        for column in table.reshape(len(table), -1).T
    ]
    return jnp.stack([jnp.asarray(each, float) for each in columns]).reshape(table.shape[1:])


def of_numbers(softness: Softness, numbers: Int[Array, " slot"]) -> Softness:
    """Returns what is constant of some contacts."""
    tables = softness._replace(dim=0)
    chosen = jax.vmap(
        lambda number: jax.tree.map(lambda table: jnp.asarray(picked(table, number)), tables[1:])
    )(numbers)
    return Softness(softness.dim, *chosen)
