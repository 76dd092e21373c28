"""From a Python function to a loaded kernel."""

import dataclasses
import time
from collections.abc import Callable, Sequence
from typing import Any

import jax
import llvmlite
import numpy as np

from mjxwalk import __version__
from mjxwalk.engines.lanes import cache, control, elementwise, indexing, moving, summing, target
from mjxwalk.engines.lanes.code import Target
from mjxwalk.engines.lanes.frame import Argument, Result
from mjxwalk.engines.lanes.graph import Graph
from mjxwalk.engines.lanes.identity import Identity, Unnamed, decoded, encoded, holds, manifest
from mjxwalk.engines.lanes.kernel import kernel
from mjxwalk.engines.lanes.program import operations, program
from mjxwalk.engines.lanes.tracing import ARGUMENT, Handler, Nodes, Refusal, Tracer

HANDLERS: dict[str, Handler] = {
    **moving.HANDLERS,
    **elementwise.HANDLERS,
    **indexing.HANDLERS,
    **summing.HANDLERS,
    **control.HANDLERS,
}

VERSIONS = (__version__, llvmlite.__version__, jax.__version__, np.__version__)


@dataclasses.dataclass(frozen=True)
class Abstract:
    """What is known of an argument in advance: one walker's shape, type and whether shared."""

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
      output_shapes, output_dtypes: of every output of one walker, in the tree's order.
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
) -> tuple[Graph, list[Nodes], Any]:
    """Returns the scalar graph of a function of one walker, its outputs and their tree."""
    leaves = [jax.ShapeDtypeStruct(a.shape, np.dtype(a.dtype), weak_type=a.weak) for a in abstracts]
    args, kwargs = jax.tree.unflatten(tree, leaves)
    jaxpr, shapes = jax.make_jaxpr(function, return_shape=True)(*args, **kwargs)
    tracer = Tracer(HANDLERS)
    inputs = [
        Nodes((ARGUMENT * (n + 1) + np.arange(a.size)).reshape(a.shape), a.dtype)
        for n, a in enumerate(abstracts)
    ]
    try:
        values = tracer.run(jaxpr.jaxpr, jaxpr.consts, inputs)
    except Refusal as refusal:
        raise refusal.error("a line that JAX did not record") from None
    outputs = [Nodes(tracer.nodes(value), value.dtype) for value in values]
    return tracer.graph, outputs, jax.tree.structure(shapes)


def compiled(
    function: Callable[..., Any], tree: Any, abstracts: Sequence[Abstract], chosen: Target
) -> Compiled:
    """Returns the kernel of a function of one walker, from the disk if it is there."""
    start = time.perf_counter()
    name, modules = _name(function, tree, abstracts, chosen)
    with cache.alone(name):
        found = _found(name, chosen, start) if name else None
        if found is not None:
            return found
        return _made(function, tree, abstracts, chosen, name, modules, start)


def _made(
    function: Callable[..., Any],
    tree: Any,
    abstracts: Sequence[Abstract],
    chosen: Target,
    name: str,
    modules: set[str],
    start: float,
) -> Compiled:
    """Returns the kernel of a function of one walker, and leaves it on the disk."""
    graph, outputs, output_tree = traced(function, tree, abstracts)
    whole = program(graph, [n for out in outputs for n in out.array.ravel().tolist()])
    text = kernel(
        whole,
        [Argument(a.size, a.dtype, a.shared) for a in abstracts],
        [Result(out.array.size, out.dtype) for out in outputs],
        chosen,
    )
    code, cached = _code(text.text, chosen)
    header: cache.Header = {
        "workspace": text.workspace,
        "shapes": [list(out.array.shape) for out in outputs],
        "dtypes": [out.dtype for out in outputs],
        "operations": operations(whole),
    }
    if name:
        _remember(name, modules, header, output_tree, code)
    return _loaded(code, chosen, header, output_tree, start, cached)


def _code(text: str, chosen: Target) -> tuple[bytes, bool]:
    """Returns the object code of IR and whether it was on the disk."""
    name = cache.digest("code", text, repr(chosen), *VERSIONS)
    entry = cache.read(name)
    if entry is not None:
        return entry[1], True
    code = target.assemble(text, chosen)
    cache.write(name, {}, code)
    return code, False


def _name(
    function: Callable[..., Any], tree: Any, abstracts: Sequence[Abstract], chosen: Target
) -> tuple[str, set[str]]:
    """Returns the name of a kernel before it is traced, or an empty one, and where it came from."""
    identity = Identity()
    try:
        text = identity.text(function)
    except Unnamed:
        return "", set()
    settings = f"x64={jax.config.values['jax_enable_x64']}"
    parts = (text, str(tree), repr(tuple(abstracts)), repr(chosen), settings, *VERSIONS)
    return cache.digest("function", *parts), identity.modules


def _remember(
    name: str, modules: set[str], header: cache.Header, output_tree: Any, code: bytes
) -> None:
    """Writes a kernel to the disk under its function's name, unless its outputs have no text."""
    files = manifest(modules)
    numbered = jax.tree.unflatten(output_tree, range(output_tree.num_leaves))
    try:
        header = {**header, "tree": encoded(numbered)}
    except Unnamed:
        return
    if files is not None:
        cache.write(name, {**header, "files": files}, code)


def _found(name: str, chosen: Target, start: float) -> Compiled | None:
    """Returns a kernel from the disk, if all that it was made from is unchanged."""
    entry = cache.read(name)
    if entry is None:
        return None
    header, code = entry
    if not holds(header["files"]):
        return None
    output_tree = jax.tree.structure(decoded(header["tree"]))
    return _loaded(code, chosen, header, output_tree, start, cached=True)


def _loaded(
    code: bytes, chosen: Target, header: cache.Header, output_tree: Any, start: float, cached: bool
) -> Compiled:
    loaded = target.Loaded(code)
    return Compiled(
        loaded=loaded,
        target=chosen,
        workspace=header["workspace"],
        output_tree=output_tree,
        output_shapes=tuple(tuple(shape) for shape in header["shapes"]),
        output_dtypes=tuple(header["dtypes"]),
        operations=header["operations"],
        seconds=time.perf_counter() - start,
        cached=cached,
    )
