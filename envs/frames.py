"""Axes of bodies, turned by constants and by joints, with nothing computed that is known."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs._mujoco import mujoco

X, Y, Z = np.eye(3)
_ROUNDING = 1e-12  # of numbers about 1, in float64
Frame = tuple[Array, Array, Array]  # a body's axes, each in those of what it is seen from


def identity() -> Frame:
    """Returns the axes of what bodies are seen from."""
    return jnp.asarray(X), jnp.asarray(Y), jnp.asarray(Z)


def along(frame: Frame, vector: Float[np.ndarray, "3"]) -> Float[Array, "3"]:
    """Returns a body's constant vector where the body is seen from."""
    return sum(
        (float(part) * axis for part, axis in zip(vector, frame, strict=True) if part),
        start=jnp.zeros(3),
    )


def matrix(quat: Float[np.ndarray, "4"]) -> Float[np.ndarray, "3 3"]:
    """Returns the matrix of a quaternion, w first."""
    flat = np.zeros(9)
    mujoco.mju_quat2Mat(flat, np.asarray(quat, np.float64))
    return flat.reshape(3, 3)


def clean(values: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    """Returns constants without what rounding left of zeros."""
    return np.where(np.abs(values) < _ROUNDING, 0.0, values)


def fixed(frame: Frame, quat: Float[np.ndarray, "4"]) -> Frame:
    """Returns the axes of a body that is turned in its parent by a constant quaternion."""
    if abs(quat[0]) == 1.0:
        return frame
    x, y, z = (along(frame, axis) for axis in matrix(quat).T)
    return x, y, z


def turned(frame: Frame, axis: Float[np.ndarray, "3"], angle: Float[Array, ""]) -> Frame:
    """Returns the axes turned about a unit vector in them."""
    sine, cosine = jnp.sin(angle), jnp.cos(angle)
    turning = int(np.argmax(np.abs(axis)))
    if abs(axis[turning]) == 1.0:  # one of the axes, or its opposite
        first, second = (turning + 1) % 3, (turning + 2) % 3
        sine = float(axis[turning]) * sine
        axes = list(frame)
        axes[first] = cosine * frame[first] + sine * frame[second]
        axes[second] = cosine * frame[second] - sine * frame[first]
        return axes[0], axes[1], axes[2]
    # Rodrigues: what lies along the axis stays, what is across it turns.
    straight = along(frame, axis)

    def turn(own: int) -> Array:
        unit = np.eye(3)[own]
        across = along(frame, unit - axis[own] * axis)
        ahead = along(frame, np.cross(axis, unit))
        return float(axis[own]) * straight + cosine * across + sine * ahead

    return turn(0), turn(1), turn(2)
