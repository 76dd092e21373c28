"""JAX's types of random keys, and what they are made of."""

from typing import Any

import jax

from mjxwalk.engines.lanes.ir.graph import Array


def is_key_type(dtype: Any) -> bool:
    """Returns whether a type is one of random keys."""
    return jax.numpy.issubdtype(dtype, jax.dtypes.prng_key)


def implementation(dtype: Any) -> Any:
    """Returns JAX's functions of the words of keys, their names and shapes (a `PRNGImpl`)."""
    return dtype._impl  # there is no public way to them; JAX 0.10


def key_type(generator: str) -> Any:
    """Returns the type of the keys of a generator, such as threefry2x32."""
    return jax.eval_shape(lambda: jax.random.key(0, impl=generator)).dtype


def wrapped(words: Array, dtype: Any) -> jax.Array:
    """Returns the random keys that are made of words, uint32[..., words]."""
    return jax.random.wrap_key_data(jax.numpy.asarray(words), impl=implementation(dtype).name)
