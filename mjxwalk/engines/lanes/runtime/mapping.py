"""`vmap`: the public face of the compiler."""

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.core
import numpy as np

from mjxwalk.engines.lanes.backend.machine_code import host
from mjxwalk.engines.lanes.compiler import Compiled, compile_function
from mjxwalk.engines.lanes.ir.graph import Array
from mjxwalk.engines.lanes.runtime import batches, thread_pool


def vmap(
    function: Callable[..., Any],
    in_axes: Any = 0,
    *,
    width: int | None = None,
    threads: int | None = None,
    results: Any = None,
) -> "Mapped":
    """Returns what `jax.jit(jax.vmap(function, in_axes))` is, compiled for the host CPU's vectors.

    Results are numpy arrays. An argument whose axis is None is shared by all walkers: it is read
    where it lies, never copied. Inside `jax.jit` the call becomes a callback.

    Like `jax.jit`, what is returned keeps what it compiled: a global that `function` reads counts
    as it is at the first call with arguments of a shape. A new `vmap` always traces anew.

    Args:
      function: works on one walker; a pure function of small arrays.
      in_axes: as `jax.vmap` takes it; keyword arguments are mapped along their first axis.
      width: lanes of a vector; None takes MJXWALK_LANES_WIDTH, or what the CPU is best at.
      threads: None takes MJXWALK_LANES_THREADS, or all CPUs that the process may use.
      results: a tree like what `function` returns. With it the program finds kernels of its own
        frozen settings without tracing; functions of others are traced all the same.

    Raises:
      CannotCompileError: when called, if the function uses what the engine cannot compile.
      ValueError: width is not one of 4, 8 and 16, or threads is below 1; when called, mapped axes
        differ in size or there is none.
    """
    return Mapped(function, in_axes, width=width, threads=threads, results=results)


class Mapped:
    """A function compiled for many walkers; it compiles anew for every new shape of arguments.

    Attributes:
      compiled: the kernel of the latest call, with its target, operations a step, and seconds.
      compile_s: seconds spent tracing and compiling so far.
      threads: how many threads run it.
      utilisation: of the latest call, the share of lane-iterations that had a walker.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        in_axes: Any,
        *,
        width: int | None,
        threads: int | None,
        results: Any,
    ) -> None:
        functools.update_wrapper(self, function, updated=())
        self.threads = thread_pool.num_threads(threads)
        self.compiled: Compiled | None = None
        self.compile_s = 0.0
        self.utilisation = 1.0
        self._function = function
        self._in_axes = in_axes
        self._results = results
        self._target = host(width)
        self._kernels: dict[Any, Compiled] = {}

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Returns the function of every walker, as a tree of numpy arrays with a leading axis."""
        leaves, tree = jax.tree.flatten((args, kwargs))
        axes = batches.axes_of_leaves(self._in_axes, args, kwargs)
        if any(isinstance(leaf, jax.core.Tracer) for leaf in leaves):
            return self._inside_jit(leaves, tree, axes)
        arrays = [batches.contiguous(leaf, axis) for leaf, axis in zip(leaves, axes, strict=True)]
        kernel = self._kernel(leaves, tree, axes)
        return self._run(kernel, arrays, batches.num_walkers(leaves, axes))

    def prepare(self, *args: Any, **kwargs: Any) -> None:
        """Compiles for arguments of these shapes without running; anything with a shape serves."""
        leaves, tree = jax.tree.flatten((args, kwargs))
        self._kernel(leaves, tree, batches.axes_of_leaves(self._in_axes, args, kwargs))

    def _kernel(self, leaves: list[Any], tree: Any, axes: list[int | None]) -> Compiled:
        arguments = tuple(
            batches.argument(leaf, axis) for leaf, axis in zip(leaves, axes, strict=True)
        )
        # Trees are equal whose static parts are: as text 1 and True differ, and 0.0 and -0.0.
        key = (arguments, str(tree), tree, _configuration())
        try:
            found = self._kernels.get(key)
        except (TypeError, ValueError):  # static parts that cannot be compared, such as arrays
            key, found = None, None
        if found is None:
            found = compile_function(self._function, tree, arguments, self._target, self._results)
            self.compile_s += found.seconds
            if key is not None:
                self._kernels[key] = found
        self.compiled = found
        return found

    def _run(self, kernel: Compiled, arrays: list[Array], count: int) -> Any:
        outputs = [np.empty((count, *result.shape), result.dtype) for result in kernel.results]
        workers = max(1, min(self.threads, -(-count // kernel.target.width)))
        self.utilisation = thread_pool.run(
            kernel.loaded, kernel.workspace, arrays, outputs, count, workers
        )
        return jax.tree.unflatten(kernel.output_tree, outputs)

    def _inside_jit(self, leaves: list[Any], tree: Any, axes: list[int | None]) -> Any:
        kernel = self._kernel(leaves, tree, axes)
        count = batches.num_walkers(leaves, axes)
        shapes = [
            jax.ShapeDtypeStruct((count, *result.shape), np.dtype(result.dtype))
            for result in kernel.results
        ]

        def run(*values: Any) -> Any:
            arrays = [
                batches.contiguous(value, axis) for value, axis in zip(values, axes, strict=True)
            ]
            return jax.tree.leaves(self._run(kernel, arrays, count))

        outputs = jax.pure_callback(run, shapes, *leaves, vmap_method="sequential")
        return jax.tree.unflatten(kernel.output_tree, outputs)


CONFIGURING = (
    "jax_enable_x64",
    "jax_default_dtype_bits",
    "jax_default_matmul_precision",
    "jax_default_prng_impl",
    "jax_enable_custom_prng",
    "jax_numpy_dtype_promotion",
    "jax_numpy_rank_promotion",
    "jax_random_seed_offset",
    "jax_threefry_partitionable",
)


def _configuration() -> tuple[Any, ...]:
    """Returns the settings of JAX that change what a trace computes, as they are in this thread."""
    return tuple(getattr(jax.config, name, None) for name in CONFIGURING)
