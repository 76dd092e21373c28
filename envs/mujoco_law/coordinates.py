"""A body's coordinates under MuJoCo's contacts: a root's quaternion as yaw, pitch and roll."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.envs import floating
from mjxwalk.envs.mujoco_law.model import MujocoModel

_PLACES, _FREE = 3, 7  # numbers of `qpos` for a free root: of its place, and with its quaternion


class Coordinates(NamedTuple):
    """Where a body is, in the coordinates of its anatomy, and their rates."""

    qpos: Float[Array, " coordinate"]
    qvel: Float[Array, " coordinate"]


def to_coordinates(
    model: MujocoModel, qpos: Float[Array, " nq"], qvel: Float[Array, " nv"]
) -> Coordinates:
    """Returns the coordinates of MuJoCo's positions and velocities."""
    if model.planar:
        return Coordinates(qpos, qvel)
    turn = jnp.asarray(model.turn, qpos.dtype)
    axes = _matrix(qpos[_PLACES:_FREE]) @ turn.T
    euler = jnp.stack(
        [
            jnp.arctan2(axes[1, 0], axes[0, 0]),
            jnp.arcsin(jnp.clip(-axes[2, 0], -1.0, 1.0)),
            jnp.arctan2(axes[2, 1], axes[2, 2]),
        ]
    )
    rates = _euler_rates(euler, turn @ qvel[_PLACES:6])
    return Coordinates(
        jnp.concatenate([qpos[:_PLACES], euler, qpos[_FREE:]]),
        jnp.concatenate([qvel[:_PLACES], rates, qvel[6:]]),
    )


def from_coordinates(
    model: MujocoModel, at: Coordinates
) -> tuple[Float[Array, " nq"], Float[Array, " nv"]]:
    """Returns MuJoCo's positions and velocities of coordinates and their rates."""
    if model.planar:
        return at.qpos, at.qvel
    turn = jnp.asarray(model.turn, at.qpos.dtype)
    euler, rates = at.qpos[3:6], at.qvel[3:6]
    quat = _quaternion(floating.rotation(euler) @ turn)
    spin = turn.T @ floating.spin(euler, rates)
    return (
        jnp.concatenate([at.qpos[:_PLACES], quat, at.qpos[6:]]),
        jnp.concatenate([at.qvel[:_PLACES], spin, at.qvel[6:]]),
    )


def _euler_rates(euler: Float[Array, "3"], spin: Float[Array, "3"]) -> Float[Array, "3"]:
    """Returns the rates of yaw, pitch and roll; the inverse of `floating.spin`."""
    _, pitch, roll = euler
    sine, cosine = jnp.sin(roll), jnp.cos(roll)
    yaw = (sine * spin[1] + cosine * spin[2]) / jnp.cos(pitch)
    return jnp.stack([yaw, cosine * spin[1] - sine * spin[2], spin[0] + yaw * jnp.sin(pitch)])


def _matrix(quat: Float[Array, "4"]) -> Float[Array, "3 3"]:
    """Returns the rotation of a quaternion of length 1, w first."""
    w, x, y, z = quat
    return jnp.stack(
        [
            jnp.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)]),
            jnp.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]),
            jnp.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]),
        ]
    )


def _quaternion(turn: Float[Array, "3 3"]) -> Float[Array, "4"]:
    """Returns the quaternion of a rotation, by whichever of its numbers is largest."""
    trace = jnp.trace(turn)
    squares = jnp.append(trace, 2.0 * jnp.diag(turn) - trace) + 1.0  # four times each, squared
    around = jnp.stack([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    both = turn + turn.T
    rows = [
        jnp.concatenate([squares[:1], around]),
        jnp.stack([around[0], squares[1], both[0, 1], both[0, 2]]),
        jnp.stack([around[1], both[0, 1], squares[2], both[1, 2]]),
        jnp.stack([around[2], both[0, 2], both[1, 2], squares[3]]),
    ]
    best, largest = rows[0], squares[0]
    for row, square in zip(rows[1:], squares[1:], strict=True):
        best = jnp.where(square > largest, row, best)
        largest = jnp.maximum(square, largest)
    return best / jnp.sqrt(jnp.sum(best**2))
