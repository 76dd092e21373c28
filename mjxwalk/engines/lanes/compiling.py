"""From a Python function to a loaded kernel."""

import dataclasses
import time
from collections.abc import Callable, Sequence
from typing import Any

import jax
import numpy as np

from mjxwalk.engines.lanes import control, elementwise, indexing, moving, summing, target
from mjxwalk.engines.lanes.emit import Target
from mjxwalk.engines.lanes.frame import Argument, Result
from mjxwalk.engines.lanes.graph import Graph
from mjxwalk.engines.lanes.kernel import kernel
from mjxwalk.engines.lanes.program import operations, program
from mjxwalk.engines.lanes.tracing import ARGUMENT, Handler, Nodes, Tracer

HANDLERS: dict[str, Handler] = {
    **moving.HANDLERS,
    **elementwise.HANDLERS,
    **indexing.HANDLERS,
    **summing.HANDLERS,
    **control.HANDLERS,
}


@dataclasses.dataclass(frozen=True)
class Abstract:
    """What is known of an argument before it is there: one walker's shape, type and whether shared."""

    shape: tuple[int, ...]
    dtype: str
    weak: bool
    shared: bool

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return int(np.prod(self.shape, dtype=np.int64))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Compiled:
    """A kernel ready to run, and what there is to say about it.

    Attributes:
      output_shapes, output_dtypes: of every output of one walker, in the order of the tree's leaves.
      seconds: what tracing and compiling took.
      cached: whether it came from the disk.
    """

    loaded: target.Loaded
    target: Target
    workspace: int
    output_tree: Any
    output_shapes: tuple[tuple[int, ...], ...]
    output_dtypes: tuple[str, ...]
    operations: int
    seconds: float
    cached: bool


def traced(
    function: Callable[..., Any], tree: Any, abstracts: Sequence[Abstract]
) -> tuple[Graph, list[Nodes], Any, list[Any]]:
    """Returns the scalar graph of a function of one walker, its outputs and their tree."""
    leaves = [jax.ShapeDtypeStruct(a.shape, np.dtype(a.dtype), weak_type=a.weak) for a in abstracts]
    args, kwargs = jax.tree.unflatten(tree, leaves)
    jaxpr, shapes = jax.make_jaxpr(function, return_shape=True)(*args, **kwargs)
    tracer = Tracer(HANDLERS)
    inputs = [
        Nodes(ARGUMENT * (n + 1) + np.arange(a.size).reshape(a.shape), a.dtype)
        for n, a in enumerate(abstracts)
    ]
    values = tracer.run(jaxpr.jaxpr, jaxpr.consts, inputs)
    outputs = [Nodes(tracer.nodes(value), value.dtype) for value in values]
    return tracer.graph, outputs, jax.tree.structure(shapes), values


def compiled(
    function: Callable[..., Any], tree: Any, abstracts: Sequence[Abstract], chosen: Target
) -> Compiled:
    """Traces and compiles a function of one walker."""
    start = time.perf_counter()
    graph, outputs, output_tree, _ = traced(function, tree, abstracts)
    whole = program(graph, [n for out in outputs for n in out.array.ravel().tolist()])
    text = kernel(
        whole,
        [Argument(a.size, a.dtype, a.shared) for a in abstracts],
        [Result(out.array.size, out.dtype) for out in outputs],
        chosen,
    )
    loaded = target.Loaded(target.assemble(text.text, chosen), chosen)
    return Compiled(
        loaded=loaded,
        target=chosen,
        workspace=text.workspace,
        output_tree=output_tree,
        output_shapes=tuple(out.array.shape for out in outputs),
        output_dtypes=tuple(out.dtype for out in outputs),
        operations=operations(whole),
        seconds=time.perf_counter() - start,
        cached=False,
    )
