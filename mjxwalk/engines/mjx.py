"""The reference engine: jit and vmap by XLA, on every device that JAX sees."""

import time
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import AxisType, NamedSharding, PartitionSpec

from mjxwalk import forking

WALKER = "walker"  # name of the mesh axis that the population is spread over


class Mapped:
    """A function for a batch of walkers, compiled on the first call with each set of shapes.

    Each device loops until its own walkers have ended, without waiting for the others.

    Attributes:
      compile_s: seconds spent tracing and compiling so far.
    """

    def __init__(self, function: Callable[..., Any], in_axes: Any) -> None:
        self.compile_s = 0.0
        self._function = function
        self._in_axes = in_axes
        # Of a run that several processes share, each has a part, and its own devices for it.
        devices = jax.local_devices()
        self._mesh = jax.make_mesh((len(devices),), (WALKER,), (AxisType.Auto,), devices=devices)
        self._compiled: dict[Any, Callable[..., Any]] = {}

    def prepare(self, *args: Any) -> None:
        """Compiles for arguments of these shapes and types; `jax.ShapeDtypeStruct`s serve.

        Raises:
          ForkedError: JAX cannot compute in this process.
        """
        forking.check()
        leaves, tree = jax.tree.flatten(args)
        axes = _axis_of_each_leaf(self._in_axes, args)
        size = _batch_size(leaves, axes)
        shapes = [self._shape(leaf, axis, size) for leaf, axis in zip(leaves, axes, strict=True)]
        self._compiled_for(tree, axes, shapes)

    def __call__(self, *args: Any) -> Any:
        """Returns the function of each walker, outputs with a leading batch axis.

        Raises:
          ForkedError: JAX cannot compute in this process.
        """
        forking.check()
        leaves, tree = jax.tree.flatten(args)
        axes = _axis_of_each_leaf(self._in_axes, args)
        size = _batch_size(leaves, axes)
        placed = [self._place(leaf, axis, size) for leaf, axis in zip(leaves, axes, strict=True)]
        outputs = self._compiled_for(tree, axes, placed)(*placed)
        return jax.tree.map(lambda leaf: leaf[:size], outputs)

    def _place(self, leaf: Any, axis: int | None, size: int) -> jax.Array:
        """Puts an argument on the devices; a batch is filled up to a multiple of their number."""
        if axis is None:
            return jax.device_put(jnp.asarray(leaf), self._sharding(axis))
        host = np.asarray(leaf)
        filled = np.concatenate([host, np.repeat(host[:1], -size % self._mesh.size, axis=0)])
        return jax.device_put(filled, self._sharding(axis))

    def _shape(self, leaf: Any, axis: int | None, size: int) -> jax.ShapeDtypeStruct:
        """Returns the shape and type of an argument once `_place` has put it on the devices."""
        shape = leaf.shape if axis is None else (size + -size % self._mesh.size, *leaf.shape[1:])
        dtype = jax.dtypes.canonicalize_dtype(leaf.dtype)
        return jax.ShapeDtypeStruct(shape, dtype, sharding=self._sharding(axis))

    def _sharding(self, axis: int | None) -> NamedSharding:
        return NamedSharding(self._mesh, _spec(axis))

    def _compiled_for(
        self, tree: Any, axes: list[int | None], placed: Sequence[jax.Array | jax.ShapeDtypeStruct]
    ) -> Callable[..., Any]:
        signature = (tree, tuple((leaf.shape, leaf.dtype) for leaf in placed))
        if signature not in self._compiled:
            self._compiled[signature] = self._compile(tree, axes, placed)
        return self._compiled[signature]

    def _compile(
        self, tree: Any, axes: list[int | None], placed: Sequence[jax.Array | jax.ShapeDtypeStruct]
    ) -> Callable[..., Any]:
        started = time.perf_counter()

        def one(*leaves: Any) -> Any:
            return self._function(*jax.tree.unflatten(tree, leaves))

        sharded = jax.shard_map(
            jax.vmap(one, in_axes=tuple(axes)),
            mesh=self._mesh,
            in_specs=tuple(map(_spec, axes)),
            out_specs=_spec(0),
            # The loop's carry starts as constants that do not vary over the mesh.
            check_vma=False,
        )
        compiled = jax.jit(sharded).lower(*placed).compile()
        self.compile_s += time.perf_counter() - started
        return compiled


def vmap(function: Callable[..., Any], in_axes: Any = 0, *, results: Any = None) -> Mapped:
    """Returns what `jax.jit(jax.vmap(function, in_axes))` returns, spread over all devices.

    Args:
      function: of the arguments of one walker.
      in_axes: 0 or None for each argument, or for each part of one, as for `jax.vmap`.
      results: not needed here; see `mjxwalk.engines.Engine`.
    """
    return Mapped(function, in_axes)


def devices() -> str:
    """Returns how many devices of which kind JAX sees."""
    return f"{len(jax.devices())} x {jax.devices()[0].device_kind}"


def _spec(axis: int | None) -> PartitionSpec:
    return PartitionSpec() if axis is None else PartitionSpec(WALKER)


def _batch_size(leaves: Sequence[Any], axes: Sequence[int | None]) -> int:
    sizes = {leaf.shape[0] for leaf, axis in zip(leaves, axes, strict=True) if axis == 0}
    if len(sizes) != 1:
        raise ValueError(f"mapped arguments must share one batch size, got {sorted(sizes)}")
    return sizes.pop()


def _axis_of_each_leaf(in_axes: Any, args: tuple[Any, ...]) -> list[int | None]:
    """Spreads a prefix tree of axes over the leaves of the arguments."""
    prefix = (in_axes,) * len(args) if in_axes is None or isinstance(in_axes, int) else in_axes
    axes: list[int | None] = []

    def spread(axis: int | None, part: Any) -> None:
        if axis not in (0, None):
            raise ValueError(f"in_axes must be 0 or None, got {axis!r}; move the batch in front")
        axes.extend([axis] * len(jax.tree.leaves(part)))

    jax.tree.map(spread, prefix, args, is_leaf=lambda node: node is None)
    return axes
