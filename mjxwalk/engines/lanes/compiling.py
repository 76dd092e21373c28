"""From a Python function to a loaded kernel."""

import dataclasses
import itertools
import time
from collections.abc import Callable, Sequence
from typing import Any

import jax
import llvmlite
import msgspec
import numpy as np

from mjxwalk import __version__, forking
from mjxwalk.engines.lanes import (
    cache,
    control,
    elementwise,
    indexing,
    moving,
    settings,
    summing,
    target,
)
from mjxwalk.engines.lanes.code import Target
from mjxwalk.engines.lanes.errors import CannotCompileError
from mjxwalk.engines.lanes.frame import Argument, Result
from mjxwalk.engines.lanes.graph import Graph
from mjxwalk.engines.lanes.kernel import kernel
from mjxwalk.engines.lanes.program import operations, program
from mjxwalk.engines.lanes.tracing import ARGUMENT, NUMBERS, Handler, Nodes, Refusal, Tracer

HANDLERS: dict[str, Handler] = {
    **moving.HANDLERS,
    **elementwise.HANDLERS,
    **indexing.HANDLERS,
    **summing.HANDLERS,
    **control.HANDLERS,
}

# JAX remembers traces by the function's object and by contexts like this one.
_TRACE = jax.make_user_context(0)
_TRACES = itertools.count(1)

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
    function: Callable[..., Any], tree: Any, abstracts: Sequence[Abstract], *, anew: bool = True
) -> tuple[Graph, list[Nodes], Any]:
    """Returns the scalar graph of a function of one walker, its outputs and their tree.

    Args:
      anew: whether to use nothing that JAX traced before, such as the body of a scan, since a
        global or an attribute that it reads may have changed.
    """
    leaves = [jax.ShapeDtypeStruct(a.shape, np.dtype(a.dtype), weak_type=a.weak) for a in abstracts]

    def flat(*leaves: Any) -> Any:
        args, kwargs = jax.tree.unflatten(tree, leaves)
        return function(*args, **kwargs)

    with _TRACE(next(_TRACES) if anew else 0):
        jaxpr, shapes = jax.make_jaxpr(flat, return_shape=True)(*leaves)
    tracer = Tracer(HANDLERS)
    for a in [*abstracts, *jax.tree.leaves(shapes)]:
        if str(a.dtype) not in NUMBERS:
            raise CannotCompileError(
                f"the lanes engine takes and returns numbers of the types {', '.join(NUMBERS)}, "
                f"got {a.dtype}; use --engine mjx"
            )
    inputs = [
        Nodes((ARGUMENT * (n + 1) + np.arange(a.size)).reshape(a.shape), a.dtype)
        for n, a in enumerate(abstracts)
    ]
    try:
        values = tracer.run(jaxpr.jaxpr, jaxpr.consts, inputs)
    except Refusal as refusal:
        raise refusal.error("a line that JAX did not record") from refusal.__cause__
    outputs = [Nodes(tracer.nodes(value), value.dtype) for value in values]
    return tracer.graph, outputs, jax.tree.structure(shapes)


class _Entry(msgspec.Struct, frozen=True):
    """A kernel that was found by its settings: where its code is, and what runs it."""

    code: str
    workspace: int
    shapes: tuple[tuple[int, ...], ...]
    dtypes: tuple[str, ...]
    operations: int
    loaded: settings.Loaded


def compiled(
    function: Callable[..., Any],
    tree: Any,
    abstracts: Sequence[Abstract],
    chosen: Target,
    results: Any = None,
) -> Compiled:
    """Returns the kernel of a function of one walker, its code from the disk if it is there.

    Args:
      results: a tree like what the function returns. With it, the kernel is found without tracing
        if the function's settings say what it computes.
    """
    start = time.perf_counter()
    key = None if results is None else settings.key(function)
    if key is None:
        return _made(function, tree, abstracts, chosen, None, start)
    parts = (key, repr(tree), repr(tuple(abstracts)), repr(chosen), *VERSIONS)
    name = cache.digest("settings", *parts)
    with cache.alone("settings", name):
        found = _found(name, chosen, jax.tree.structure(results), start)
        return found or _made(function, tree, abstracts, chosen, name, start)


def _made(
    function: Callable[..., Any],
    tree: Any,
    abstracts: Sequence[Abstract],
    chosen: Target,
    name: str | None,
    start: float,
) -> Compiled:
    """Returns the kernel of a function of one walker, traced; writes it under a name if given."""
    forking.check()  # JAX may have to compute what is known while tracing
    graph, outputs, output_tree = traced(function, tree, abstracts, anew=name is None)
    whole = program(graph, [n for out in outputs for n in out.array.ravel().tolist()])
    text = kernel(
        whole,
        [Argument(a.size, a.dtype, a.shared) for a in abstracts],
        [Result(out.array.size, out.dtype) for out in outputs],
        chosen,
    )
    code_name = cache.digest("code", text.text, repr(chosen), *VERSIONS)
    code, cached = _code(code_name, text.text, chosen)
    loaded = None if name is None else settings.loaded()
    entry = _Entry(
        code=code_name,
        workspace=text.workspace,
        shapes=tuple(tuple(out.array.shape) for out in outputs),
        dtypes=tuple(out.dtype for out in outputs),
        operations=operations(whole),
        loaded=loaded or settings.Loaded({}, {}),
    )
    if name is not None and loaded is not None:
        cache.write(name, msgspec.to_builtins(entry), b"")
    return _ready(code, chosen, entry, output_tree, start, cached)


def _code(name: str, text: str, chosen: Target) -> tuple[bytes, bool]:
    """Returns the object code of IR, by a name that depends on all of it; whether it was there."""
    with cache.alone("code", name):
        found = cache.read(name)
        if found is not None:
            return found[1], True
        code = target.assemble(text, chosen)
        cache.write(name, {}, code)
        return code, False


def _found(name: str, chosen: Target, output_tree: Any, start: float) -> Compiled | None:
    """Returns a kernel from the disk, if all that it was made from is unchanged."""
    found = cache.read(name)
    if found is None:
        return None
    try:
        entry = msgspec.convert(found[0], _Entry)
    except msgspec.ValidationError:
        return None
    code = cache.read(entry.code)
    if code is None or len(entry.shapes) != output_tree.num_leaves:
        return None
    if not settings.holds(entry.loaded):
        return None
    return _ready(code[1], chosen, entry, output_tree, start, cached=True)


def _ready(
    code: bytes, chosen: Target, entry: _Entry, output_tree: Any, start: float, cached: bool
) -> Compiled:
    loaded = target.Loaded(code)
    return Compiled(
        loaded=loaded,
        target=chosen,
        workspace=entry.workspace,
        output_tree=output_tree,
        output_shapes=entry.shapes,
        output_dtypes=entry.dtypes,
        operations=entry.operations,
        seconds=time.perf_counter() - start,
        cached=cached,
    )
