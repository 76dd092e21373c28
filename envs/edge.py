"""The edge of bodies and controllers: NumPy arrays, lists and numbers become JAX's arrays there."""

import functools
from collections.abc import Callable
from typing import Any, TypeVar, cast

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])


def takes_arrays(method: FunctionT) -> FunctionT:
    """Returns a method that is given JAX's arrays, whatever its caller has.

    Args:
      method: whose arguments are named tuples of arrays, or arrays.
    """

    @functools.wraps(method)
    def converted(self: Any, *values: Any) -> Any:
        return method(self, *map(as_arrays, values))

    return cast("FunctionT", converted)


def takes_genotype(method: FunctionT) -> FunctionT:
    """Returns a controller's method as `takes_arrays` does, given a genotype of its template first.

    The method raises ValueError where the genotype has another structure or shape.
    """

    @functools.wraps(method)
    def converted(self: Any, genotype: Any, *values: Any) -> Any:
        genotype = as_arrays(genotype)
        check_shapes("genotype", genotype, jax.eval_shape(self.template))
        return method(self, genotype, *map(as_arrays, values))

    return cast("FunctionT", converted)


def check_shapes(name: str, tree: Any, like: Any) -> None:
    """Raises unless a pytree of arrays has the structure and the shapes of another.

    Args:
      name: of the pytree, for the error.
      tree: to check.
      like: what it must be like.

    Raises:
      ValueError: its structure or the shape of a leaf differs.
    """
    structures = jax.tree.structure(like), jax.tree.structure(tree)
    if structures[0] != structures[1]:
        raise ValueError(f"{name} must be a pytree {structures[0]}, got {structures[1]}")
    for (path, leaf), wanted in zip(
        jax.tree.leaves_with_path(tree), jax.tree.leaves(like), strict=True
    ):
        if jnp.shape(leaf) != wanted.shape:
            where = f"{name}{jax.tree_util.keystr(path)}"
            raise ValueError(f"{where} must have shape {wanted.shape}, got {jnp.shape(leaf)}")


def as_arrays(value: Any) -> Any:
    """Returns a tuple of arrays, named or not, or an array, with every part an array of JAX's.

    What is neither numbers nor a named tuple stays as it is.
    """
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return type(value)(*map(as_arrays, value))
    if isinstance(value, tuple) and all(hasattr(part, "shape") for part in value):
        return tuple(map(as_arrays, value))  # of layers, say; numbers in a tuple are one array
    if isinstance(value, int | float):
        value = np.asarray(value)  # whose dtype does not give way to others, as a number's does
    if isinstance(value, np.ndarray | np.generic | list | tuple):
        return jnp.asarray(value)
    return value


def check_terrain(terrain: Any, nodes: tuple[int, ...]) -> None:
    """Raises unless a terrain is a table of so many nodes a row, or more, and one of its rows.

    A row that is being traced is unknown and passes unchecked.

    Raises:
      ValueError: the table has another shape, or the row is none of it.
    """
    heights, row, *_ = terrain
    found, least = jnp.shape(heights), (1, *nodes)
    if len(found) != len(least) or any(n < m for n, m in zip(found, least, strict=True)):
        wanted = ", ".join(map(str, nodes))
        raise ValueError(f"heights must have shape (terrains, {wanted}) at least, got {found}")
    dtype, shape = jnp.result_type(row), jnp.shape(row)
    if not jnp.issubdtype(dtype, jnp.integer) or shape:
        raise ValueError(f"row must be one whole number, got {dtype} of shape {shape}")
    if not isinstance(row, Tracer) and not 0 <= int(row) < heights.shape[0]:
        raise ValueError(f"row must be from 0 to {heights.shape[0] - 1}, got {row}")


def check_pushes(pushes: Any, number: int) -> None:
    """Raises ValueError unless there are so many pushes, of three numbers each."""
    if jnp.shape(pushes) != (number, 3):
        raise ValueError(f"push must have shape {(number, 3)}, got {jnp.shape(pushes)}")


def check_course(terrain: Any, least: tuple[int, int]) -> None:
    """Raises ValueError unless there is a course for each terrain, of these nodes and channels."""
    found, wanted = jnp.shape(terrain.course), (jnp.shape(terrain.heights)[0], *least)
    if found != wanted:
        raise ValueError(f"course must have shape {wanted}, got {found}")
