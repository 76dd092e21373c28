"""The scalar graph of the lanes engine as JAX operations, which XLA compiles for any device."""

from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.custom_batching import custom_vmap

from mjxwalk.engines import mjx
from mjxwalk.engines.lanes.backend import jax_operations
from mjxwalk.engines.lanes.frontend.tracing import trace
from mjxwalk.engines.lanes.ir.scheduling import build_program
from mjxwalk.engines.lanes.ir.signature import Argument, Result
from mjxwalk.engines.lanes.ir.simplify import simplifying
from mjxwalk.engines.mjx import devices

__all__ = ["devices", "scalarised", "vmap"]


def vmap(function: Callable[..., Any], in_axes: Any = 0, *, results: Any = None) -> mjx.Mapped:
    """Returns what `jax.jit(jax.vmap(function, in_axes))` is, from the scalar graph, by XLA.

    Runs on every device that JAX sees.

    Args:
      function: works on one walker; a pure function of small arrays.
      in_axes: 0 or None for each argument, or for each part of one, as for `jax.vmap`.
      results: not needed here; see `mjxwalk.engines.Engine`.

    Raises:
      CannotCompileError: when called, if the function uses what the engine cannot compile.
      ValueError: when called, mapped axes differ in size or there is none.
    """
    return mjx.vmap(scalarised(function), in_axes)


def scalarised(function: Callable[..., Any]) -> Callable[..., Any]:
    """Returns a function that is the same, and whose `jax.vmap` is made from the scalar graph."""
    wrapped = custom_vmap(function)

    def rule(size: int, in_batched: list[Any], *args: Any) -> tuple[Any, Any]:
        leaves, tree = jax.tree.flatten((args, {}))
        shared = [not batched for batched in jax.tree.leaves(in_batched)]
        made = _batched(function, tree, leaves, shared, size)
        return made, jax.tree.map(lambda _: True, made)

    wrapped.def_vmap(rule)
    return wrapped


def _batched(
    function: Callable[..., Any],
    tree: Any,
    leaves: Sequence[Any],
    shared: Sequence[bool],
    size: int,
) -> Any:
    """Returns a function of a batch, walkers first in arguments and results."""
    arguments = [_argument(leaf, alike) for leaf, alike in zip(leaves, shared, strict=True)]
    traced = trace(function, tree, arguments)
    inputs = [
        jnp.ravel(leaf) if alike else jnp.reshape(leaf, (size, -1)).T
        for leaf, alike in zip(leaves, shared, strict=True)
    ]
    whole = build_program(traced.graph, traced.outputs, simplifying)
    made = iter(jax_operations.outputs(whole, inputs, shared, size))
    outputs = [_rows([next(made) for _ in range(r.size)], r, size) for r in traced.results]
    return jax.tree.unflatten(traced.tree, outputs)


def _rows(numbers: list[jax.Array], result: Result, size: int) -> jax.Array:
    """Returns an output from its numbers, walkers first."""
    shape = (size, *result.shape)
    if not numbers:
        return jnp.zeros(shape, result.dtype)
    return jnp.stack(numbers, axis=-1).reshape(shape)


def _argument(leaf: Any, shared: bool) -> Argument:
    shape = np.shape(leaf) if shared else np.shape(leaf)[1:]
    return Argument(shape, leaf.dtype.name, bool(getattr(leaf, "weak_type", False)), shared)
