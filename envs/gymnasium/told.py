"""What MuJoCo's data hold beside positions and velocities, of the last state that was computed.

MuJoCo moves positions and velocities at the end of a step and computes nothing of them. With the
method of Runge and Kutta inertias, places and forces then are those of its last stage.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.envs.mujoco_law import external, tree_data
from mjxwalk.envs.mujoco_law.forward import Forward
from mjxwalk.envs.mujoco_law.model import MujocoModel

Place = Callable[[Any], Float[Array, ""]]


class Told(NamedTuple):
    """Values that a task observes or is rewarded for; None where the task needs none.

    Attributes:
      ahead: how far what its speed is measured at is ahead of the first coordinate, m.
      cinert: MuJoCo's inertias about the tree's centre of mass.
      cvel: velocities there, the angular one first, rad/s and m/s.
      qfrc_actuator: forces of the motors, N m.
      cfrc_ext: torques and forces of contacts about the centre of mass, N m and N.
    """

    ahead: Float[Array, ""] | None = None
    cinert: Float[Array, "body 10"] | None = None
    cvel: Float[Array, "body 6"] | None = None
    qfrc_actuator: Float[Array, " nv"] | None = None
    cfrc_ext: Float[Array, "body 6"] | None = None


def of_start(data: Any, names: tuple[str, ...], place: Place) -> Told:
    """Returns what is told at the start of a trial: no forces yet.

    Args:
      data: the `mjx.Data` with places and velocities.
      names: of the values that are needed.
      place: where along x the speed is measured, m.
    """
    bodies, dofs = data.cvel.shape[0], data.qvel.shape[0]
    values = {
        "ahead": place(data) - data.qpos[0],
        "cinert": data._impl.cinert,
        "cvel": data.cvel,
        "qfrc_actuator": jnp.zeros(dofs),
        "cfrc_ext": jnp.zeros((bodies, 6)),
    }
    return Told(**{name: values[name] for name in names})


def of_forward(model: MujocoModel, now: Forward, names: tuple[str, ...], place: Place) -> Told:
    """Returns the values of one evaluation of forces; `ahead` is the place itself."""
    data = tree_data.about_centre(model, now.data)
    values: dict[str, Callable[[], Array]] = {
        "ahead": lambda: place(data),
        "cinert": lambda: data._impl.cinert,
        "cvel": lambda: data.cvel,
        "qfrc_actuator": lambda: external.of_motors(model, now),
        "cfrc_ext": lambda: external.wrenches(model, now._replace(data=data)),
    }
    return Told(**{name: values[name]() for name in names})
