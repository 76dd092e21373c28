"""The scalar graph of the lanes engine as PTX, which an NVIDIA GPU runs with a walker a thread.

It is no engine of the program's: `scripts/gpu_check.py` runs it beside those that are.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import numpy as np

from mjxwalk.engines.cuda_driver import Device, Kernel
from mjxwalk.engines.lanes.backend import ptx
from mjxwalk.engines.lanes.frontend.tracing import trace
from mjxwalk.engines.lanes.ir.program import Program
from mjxwalk.engines.lanes.ir.scheduling import build_program
from mjxwalk.engines.lanes.ir.signature import Argument, Result
from mjxwalk.engines.lanes.runtime import batches

__all__ = ["Lowered", "Mapped", "lower", "vmap"]


class Lowered(NamedTuple):
    """A function of one walker as a program.

    Attributes:
      arguments, results: in the order of the trees' leaves.
      tree: of what the function returns.
    """

    program: Program
    arguments: tuple[Argument, ...]
    results: tuple[Result, ...]
    tree: Any

    def ptx(self) -> str:
        """Returns the program's PTX."""
        return ptx.emit_ptx(self.program, self.arguments, self.results)


def lower(function: Callable[..., Any], in_axes: Any, *args: Any) -> Lowered:
    """Returns the program of a function of one walker; anything with a shape serves as argument.

    Raises:
      CannotCompileError: the function uses what the engine cannot compile.
    """
    leaves, tree = jax.tree.flatten((args, {}))
    axes = batches.axes_of_leaves(in_axes, args, {})
    arguments = tuple(batches.argument(*pair) for pair in zip(leaves, axes, strict=True))
    traced = trace(function, tree, arguments)
    program = build_program(traced.graph, traced.outputs)
    return Lowered(program, arguments, traced.results, traced.tree)


def vmap(function: Callable[..., Any], in_axes: Any = 0, *, device: Any = None) -> "Mapped":
    """Returns what `jax.jit(jax.vmap(function, in_axes))` is, compiled for an NVIDIA GPU.

    Args:
      function: works on one walker; a pure function of small arrays.
      in_axes: as `jax.vmap` takes it.
      device: a `cuda_driver.Device`; None for the first one.

    Raises:
      CudaError: there is no such GPU.
    """
    return Mapped(function, in_axes, Device() if device is None else device)


class Mapped:
    """A function compiled for a GPU; it compiles anew for every new shape of arguments.

    Attributes:
      kernel: of the latest call.
      seconds: of the latest call on the GPU alone, without copies.
    """

    def __init__(self, function: Callable[..., Any], in_axes: Any, device: Device) -> None:
        self.kernel: Kernel | None = None
        self.seconds = 0.0
        self._function = function
        self._in_axes = in_axes
        self._device = device
        self._kernels: dict[Any, tuple[Lowered, Kernel]] = {}

    def __call__(self, *args: Any) -> Any:
        """Returns the function of every walker, as a tree of numpy arrays with a leading axis.

        Raises:
          CannotCompileError: the function uses what the engine cannot compile.
          CudaError: the GPU failed.
        """
        leaves = jax.tree.leaves(args)
        axes = batches.axes_of_leaves(self._in_axes, args, {})
        lowered, self.kernel = self._kernel(args, leaves, axes)
        inputs = [batches.contiguous(*pair) for pair in zip(leaves, axes, strict=True)]
        count = batches.num_walkers(leaves, axes)
        outputs = [np.empty((count, *result.shape), result.dtype) for result in lowered.results]
        self.seconds = self._device.run(self.kernel, inputs, outputs, count, ptx.THREADS)
        return jax.tree.unflatten(lowered.tree, outputs)

    def _kernel(
        self, args: Any, leaves: Sequence[Any], axes: Sequence[int | None]
    ) -> tuple[Lowered, Kernel]:
        """Returns the program and the kernel for arguments of these shapes."""
        arguments = tuple(batches.argument(*pair) for pair in zip(leaves, axes, strict=True))
        tree = jax.tree.structure(args)
        # Trees are equal whose static parts are: as text 1 and True differ, and 0.0 and -0.0.
        key = arguments, str(tree), tree
        if key not in self._kernels:
            lowered = lower(self._function, self._in_axes, *args)
            self._kernels[key] = lowered, self._device.load(lowered.ptx(), ptx.ENTRY)
        return self._kernels[key]
