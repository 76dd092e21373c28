"""Compiles any small JAX function for the vectors of the CPU: a Van der Pol oscillator.

python examples/lanes_vmap.py
"""

import jax
import jax.numpy as jnp
import numpy as np

from mjxwalk.engines import lanes


def settle(mu, start):
    """Returns place and speed of an oscillator after 20 s."""

    def step(at):
        time, x, v = at
        return time + 0.01, x + 0.01 * v, v + 0.01 * (mu * (1.0 - x * x) * v - x)

    _, x, v = jax.lax.while_loop(lambda at: at[0] < 20.0, step, (0.0, start, jnp.zeros(())))
    return x, v


mus = np.linspace(0.1, 5.0, 100_000, dtype=np.float32)
x, v = lanes.vmap(settle)(mus, np.ones_like(mus))
expected, _ = jax.jit(jax.vmap(settle))(mus[:10], np.ones(10, np.float32))
print(f"{len(x):,} oscillators; off JAX's own by {np.abs(x[:10] - expected).max():.1e}")
