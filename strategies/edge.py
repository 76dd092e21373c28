"""The edge of every strategy: what callers give is converted here, or refused in a sentence.

`Strategy` puts these functions around its own, so that inside a strategy all arrays are JAX's, of
known shapes and dtypes, whatever a simulator or a file gave: NumPy arrays, lists, whole numbers,
numbers of half or of double precision. States keep the dtypes that `init` gave them, as
`jax.lax.scan` and checkpoints need, also where `jax_enable_x64` makes constants double.
"""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Float

KEYSTR = jax.tree_util.keystr


def init(own: Any, key: Any, template: Any) -> Any:
    """Returns a strategy's first state.

    Raises:
      ValueError: the key is none, a leaf of the template is no float or array of floats, or there
        is no weight.
    """
    return own(as_key(key), as_template(template))


def ask(own: Any, key: Any, state: Any) -> tuple[Any, Any]:
    """Returns a strategy's population, and its state in the dtypes of before.

    Raises:
      ValueError: the key is none.
    """
    state = _as_arrays(state)
    population, after = own(as_key(key), state)
    return population, _in_dtypes_of(state, after)


def tell(
    own: Any, asked: Any, size: int, key: Any, population: Any, fitness: Any, state: Any
) -> tuple[Any, Any]:
    """Returns a strategy's next state, in the dtypes of before, and its metrics.

    Raises:
      ValueError: as `told`.
    """
    state = _as_arrays(state)
    key, population, fitness = told(asked, size, key, population, fitness, state)
    after, metrics = own(key, population, fitness, state)
    return _in_dtypes_of(state, after), metrics


def told(
    asked: Any, size: int, key: Any, population: Any, fitness: Any, state: Any
) -> tuple[Any, Any, Float[Array, " pop"]]:
    """Returns a key, a population as it was handed out, and one float for each of its genotypes.

    Args:
      asked: the strategy's `ask` under `jax.jit`, which remembers what it hands out.
      size: genotypes in a generation.
      key: random key.
      population: as the caller has it.
      fitness: as the caller has it.
      state: of the strategy.

    Raises:
      ValueError: the key is none, or the population or the fitness has another structure or shape
        than what was asked for, or holds something else than real numbers.
    """
    key = as_key(key)
    fitness = as_floats("fitness", fitness)
    if fitness.shape != (size,):
        raise ValueError(f"fitness must have shape ({size},), got {fitness.shape}")
    expected, _ = asked.eval_shape(key, state)
    structures = jax.tree.structure(expected), jax.tree.structure(population)
    if structures[0] != structures[1]:
        raise ValueError(f"population must be a pytree {structures[0]}, got {structures[1]}")

    def fit(path: Any, leaf: Any, like: Any) -> Array:
        name = f"population{KEYSTR(path)}"
        array = as_floats(name, leaf)
        if array.shape != like.shape:
            raise ValueError(f"{name} must have shape {like.shape}, got {array.shape}")
        return array.astype(like.dtype)

    return key, jax.tree.map_with_path(fit, population, expected), fitness


def as_key(key: Any) -> Any:
    """Returns a random key.

    Raises:
      ValueError: it is none, neither of `jax.random.key` nor the words of one.
    """
    dtype = getattr(key, "dtype", None)
    if dtype is None or not (dtype == np.uint32 or jnp.issubdtype(dtype, jax.dtypes.prng_key)):
        raise ValueError(f"key must be a random key, as jax.random.key(0), got {key!r}")
    return key if isinstance(key, jax.Array) else jnp.asarray(key)


def as_template(template: Any) -> Any:
    """Returns a template as a pytree of float arrays with at least one weight.

    Raises:
      ValueError: a leaf is no float or array of floats, or there is no weight.
    """

    def convert(path: Any, leaf: Any) -> Array:
        dtype = jnp.result_type(leaf) if isinstance(leaf, float) else getattr(leaf, "dtype", None)
        if dtype is None or not jnp.issubdtype(dtype, jnp.floating):
            found = type(leaf).__name__ if dtype is None else dtype
            raise ValueError(f"template{KEYSTR(path)} must be an array of floats, got {found}")
        return _strong(leaf)

    converted = jax.tree.map_with_path(convert, template)
    if not sum(leaf.size for leaf in jax.tree.leaves(converted)):
        raise ValueError("template must hold at least one weight, got none")
    return converted


def as_floats(name: str, values: Any) -> Float[Array, "..."]:
    """Returns numbers as floats of single precision or better; NaN stays NaN.

    Args:
      name: what they are, for the error.
      values: an array of any kind, a number, or a sequence of them; booleans are 0 and 1.

    Raises:
      ValueError: they are no real numbers, or sequences of different lengths.
    """
    array = values if isinstance(values, jax.Array) else _from_outside(name, values)
    if jnp.issubdtype(array.dtype, jnp.floating):
        is_half = jnp.finfo(array.dtype).bits < 32
        return _strong(array.astype(jnp.float32) if is_half else array)
    if array.dtype != bool and not jnp.issubdtype(array.dtype, jnp.integer):
        raise ValueError(f"{name} must hold real numbers, got {array.dtype}")
    # NumPy's whole numbers of 64 bits would be cut to 32 by JAX before they became floats.
    return _strong(array.astype(float))


def _from_outside(name: str, values: Any) -> Any:
    """Returns what is no array of JAX's as an array."""
    try:
        if any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves(values)):
            return jnp.asarray(values)
        return np.asarray(values)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"{name} must be an array of numbers, got {type(values).__name__}"
        ) from error


def _strong(values: Any) -> Array:
    """Returns an array whose dtype does not give way to others, as that of a number does."""
    array = jnp.asarray(values)
    return jax.lax.convert_element_type(array, array.dtype)


def _as_arrays(state: Any) -> Any:
    """Returns a state, such as one from a file, with JAX's arrays in place of NumPy's."""
    return jax.tree.map(
        lambda leaf: jnp.asarray(leaf) if isinstance(leaf, np.ndarray | np.generic) else leaf, state
    )


def _in_dtypes_of(before: Any, after: Any) -> Any:
    """Returns a state in the dtypes of the one before it; itself if the two are built otherwise."""
    if jax.tree.structure(before) != jax.tree.structure(after):
        return after

    def cast(old: Any, new: Any) -> Any:
        if getattr(old, "dtype", None) in (None, getattr(new, "dtype", None)):
            return new
        return jnp.asarray(new).astype(old.dtype)

    return jax.tree.map(cast, before, after)
