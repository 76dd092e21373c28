"""The reference engine: jit and vmap by XLA, on every device that JAX sees."""

import time
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import AxisType, NamedSharding, PartitionSpec

from mjxwalk import forking

WALKER = "walker"  # name of the mesh axis that the population is spread over


class Mapped:
    """`fn` for a batch of walkers, compiled on the first call with each set of shapes.

    Each device loops until its own walkers have ended, without waiting for the others.

    Attributes:
      compile_s: seconds spent tracing and compiling so far.
    """

    def __init__(self, fn: Callable[..., Any], in_axes: Any) -> None:
        self.compile_s = 0.0
        self._fn = fn
        self._in_axes = in_axes
        # Of a run that several processes share, each has a part, and its own devices for it.
        devices = jax.local_devices()
        self._mesh = jax.make_mesh((len(devices),), (WALKER,), (AxisType.Auto,), devices=devices)
        self._compiled: dict[Any, Callable[..., Any]] = {}

    def __call__(self, *args: Any) -> Any:
        """Returns fn of each walker, outputs with a leading batch axis.

        Raises:
          ForkedError: JAX cannot compute in this process.
        """
        forking.check()
        axes = _axis_of_each_leaf(self._in_axes, args)
        leaves, tree = jax.tree.flatten(args)
        sizes = {leaf.shape[0] for leaf, axis in zip(leaves, axes, strict=True) if axis == 0}
        if len(sizes) != 1:
            raise ValueError(f"mapped arguments must share one batch size, got {sorted(sizes)}")
        size = sizes.pop()
        placed = [self._place(leaf, axis, size) for leaf, axis in zip(leaves, axes, strict=True)]
        signature = (tree, tuple((leaf.shape, leaf.dtype) for leaf in placed))
        if signature not in self._compiled:
            self._compiled[signature] = self._compile(tree, axes, placed)
        outputs = self._compiled[signature](*placed)
        return jax.tree.map(lambda leaf: leaf[:size], outputs)

    def _place(self, leaf: Any, axis: int | None, size: int) -> jax.Array:
        """Puts an argument on the devices; a batch is filled up to a multiple of their number."""
        if axis is None:
            return jax.device_put(jnp.asarray(leaf), NamedSharding(self._mesh, PartitionSpec()))
        missing = -size % self._mesh.size
        host = np.asarray(leaf)
        filled = np.concatenate([host, np.repeat(host[:1], missing, axis=0)])
        return jax.device_put(filled, NamedSharding(self._mesh, PartitionSpec(WALKER)))

    def _compile(
        self, tree: Any, axes: list[int | None], placed: list[jax.Array]
    ) -> Callable[..., Any]:
        started = time.perf_counter()

        def one(*leaves: Any) -> Any:
            return self._fn(*jax.tree.unflatten(tree, leaves))

        specs = tuple(PartitionSpec(WALKER) if axis == 0 else PartitionSpec() for axis in axes)
        sharded = jax.shard_map(
            jax.vmap(one, in_axes=tuple(axes)),
            mesh=self._mesh,
            in_specs=specs,
            out_specs=PartitionSpec(WALKER),
            # The loop's carry starts as constants that do not vary over the mesh.
            check_vma=False,
        )
        compiled = jax.jit(sharded).lower(*placed).compile()
        self.compile_s += time.perf_counter() - started
        return compiled


def vmap(fn: Callable[..., Any], in_axes: Any = 0) -> Mapped:
    """Returns what `jax.jit(jax.vmap(fn, in_axes))` returns, spread over all devices.

    Args:
      fn: of the arguments of one walker.
      in_axes: 0 or None for each argument, or for each part of one, as for `jax.vmap`.
    """
    return Mapped(fn, in_axes)


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
