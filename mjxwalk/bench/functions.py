"""Functions to minimise, as BBOB's, without the irregularities that BBOB puts over them.

Hansen, Finck, Ros & Auger (2009), "Real-parameter black-box optimization benchmarking 2009:
noiseless functions definitions", INRIA research report RR-6829,
https://hal.inria.fr/inria-00362633; numbers are that report's. All are 0 at their lowest.
"""

from collections.abc import Callable, Mapping

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

Function = Callable[[Float[Array, "pop dim"]], Float[Array, " pop"]]


def sphere(x: Float[Array, "pop dim"]) -> Float[Array, " pop"]:
    """Returns the sum of squares; function 1."""
    return jnp.sum(x**2, axis=1)


def ellipsoid(x: Float[Array, "pop dim"]) -> Float[Array, " pop"]:
    """Returns the sum of squares weighted from 1 to a million; function 2."""
    return jnp.sum(10.0 ** jnp.linspace(0, 6, x.shape[1]) * x**2, axis=1)


def rastrigin(x: Float[Array, "pop dim"]) -> Float[Array, " pop"]:
    """Returns the sphere with ripples, each of them a local minimum; function 3."""
    return jnp.sum(x**2 - 10 * jnp.cos(2 * jnp.pi * x) + 10, axis=1)


def rosenbrock(x: Float[Array, "pop dim"]) -> Float[Array, " pop"]:
    """Returns the height in a bent valley whose lowest point is at one; function 8."""
    return jnp.sum(100 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1 - x[:, :-1]) ** 2, axis=1)


def turned_ellipsoid(x: Float[Array, "pop dim"]) -> Float[Array, " pop"]:
    """Returns the ellipsoid with its axes turned at random; function 10."""
    return ellipsoid(turn(x))


def discus(x: Float[Array, "pop dim"]) -> Float[Array, " pop"]:
    """Returns the sum of squares of which one, turned, counts a million times; function 11."""
    turned = turn(x)
    return 1e6 * turned[:, 0] ** 2 + jnp.sum(turned[:, 1:] ** 2, axis=1)


def turned_rastrigin(x: Float[Array, "pop dim"]) -> Float[Array, " pop"]:
    """Returns the ripples with their axes turned at random; function 15."""
    return rastrigin(turn(x))


def schaffers(x: Float[Array, "pop dim"]) -> Float[Array, " pop"]:
    """Returns ripples that become finer and lower towards the lowest point; function 17."""
    lengths = jnp.sqrt(turn(x)[:, :-1] ** 2 + turn(x)[:, 1:] ** 2)
    roots = jnp.sqrt(lengths)
    return jnp.mean(roots + roots * jnp.sin(50 * lengths**0.2) ** 2, axis=1) ** 2


def turn(x: Float[Array, "pop dim"]) -> Float[Array, "pop dim"]:
    """Returns points turned about 0, always in the same way."""
    num_weights = x.shape[1]
    noise = np.random.default_rng(num_weights).normal(size=(num_weights, num_weights))
    return x @ jnp.asarray(np.linalg.qr(noise)[0], x.dtype)


FUNCTIONS: Mapping[str, Function] = {
    "sphere": sphere,
    "ellipsoid": ellipsoid,
    "rastrigin": rastrigin,
    "rosenbrock": rosenbrock,
    "turned ellipsoid": turned_ellipsoid,
    "discus": discus,
    "turned rastrigin": turned_rastrigin,
    "schaffers": schaffers,
}
