"""From a Python function to a loaded kernel."""

import dataclasses
import time
from collections.abc import Callable, Sequence
from typing import Any

import jax
import llvmlite
import msgspec
import numpy as np

from mjxwalk import __version__, forking
from mjxwalk.engines.lanes.backend import machine_code
from mjxwalk.engines.lanes.backend.kernel import emit_kernel
from mjxwalk.engines.lanes.backend.target import Target
from mjxwalk.engines.lanes.cache import entries, settings_key
from mjxwalk.engines.lanes.frontend.tracing import trace
from mjxwalk.engines.lanes.ir.scheduling import build_program
from mjxwalk.engines.lanes.ir.signature import Argument, Result

VERSIONS = (__version__, llvmlite.__version__, jax.__version__, np.__version__)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Compiled:
    """A kernel ready to run, and what there is to say about it.

    Attributes:
      results: every output of one walker, in the tree's order.
      seconds: what tracing and compiling took.
      cached: whether it came from the disk.
    """

    loaded: machine_code.Loaded
    target: Target
    workspace: int
    output_tree: Any
    results: tuple[Result, ...]
    operations: int
    seconds: float
    cached: bool


class _Entry(msgspec.Struct, frozen=True):
    """A kernel that was found by its settings: where its code is, and what runs it."""

    code: str
    workspace: int
    results: tuple[Result, ...]
    operations: int
    dependencies: settings_key.Dependencies


def compile_function(
    function: Callable[..., Any],
    tree: Any,
    arguments: Sequence[Argument],
    chosen: Target,
    results: Any = None,
) -> Compiled:
    """Returns the kernel of a function of one walker, its code from the disk if it is there.

    Args:
      results: a tree like what the function returns. With it, the kernel is found without tracing
        if the function's settings say what it computes.
    """
    start = time.perf_counter()
    key = None if results is None else settings_key.key(function)
    if key is None:
        return _compile_anew(function, tree, arguments, chosen, None, start)
    parts = (key, repr(tree), repr(tuple(arguments)), repr(chosen), *VERSIONS)
    name = entries.digest("settings", *parts)
    with entries.alone("settings", name):
        found = _look_up(name, chosen, jax.tree.structure(results), start)
        return found or _compile_anew(function, tree, arguments, chosen, name, start)


def _compile_anew(
    function: Callable[..., Any],
    tree: Any,
    arguments: Sequence[Argument],
    chosen: Target,
    name: str | None,
    start: float,
) -> Compiled:
    """Returns the kernel of a function of one walker, traced; writes it under a name if given."""
    forking.check()  # JAX may have to compute what is known while tracing
    traced = trace(function, tree, arguments, anew=name is None)
    program = build_program(traced.graph, traced.outputs)
    kernel = emit_kernel(program, arguments, traced.results, chosen)
    code_name = entries.digest("code", kernel.text, repr(chosen), *VERSIONS)
    code, cached = _object_code(code_name, kernel.text, chosen)
    dependencies = None if name is None else settings_key.dependencies()
    entry = _Entry(
        code=code_name,
        workspace=kernel.workspace,
        results=traced.results,
        operations=program.num_operations,
        dependencies=dependencies or settings_key.Dependencies({}, {}),
    )
    if name is not None and dependencies is not None:
        entries.write(name, msgspec.to_builtins(entry), b"")
    return _load(code, chosen, entry, traced.tree, start, cached)


def _object_code(name: str, text: str, chosen: Target) -> tuple[bytes, bool]:
    """Returns the object code of IR, by a name that depends on all of it; whether it was there."""
    with entries.alone("code", name):
        found = entries.read(name)
        if found is not None:
            return found[1], True
        code = machine_code.assemble(text, chosen)
        entries.write(name, {}, code)
        return code, False


def _look_up(name: str, chosen: Target, output_tree: Any, start: float) -> Compiled | None:
    """Returns a kernel from the disk, if all that it was made from is unchanged."""
    found = entries.read(name)
    if found is None:
        return None
    try:
        entry = msgspec.convert(found[0], _Entry)
    except msgspec.ValidationError:
        return None
    code = entries.read(entry.code)
    if code is None or len(entry.results) != output_tree.num_leaves:
        return None
    if not settings_key.are_unchanged(entry.dependencies):
        return None
    return _load(code[1], chosen, entry, output_tree, start, cached=True)


def _load(
    code: bytes, chosen: Target, entry: _Entry, output_tree: Any, start: float, cached: bool
) -> Compiled:
    return Compiled(
        loaded=machine_code.Loaded(code),
        target=chosen,
        workspace=entry.workspace,
        output_tree=output_tree,
        results=entry.results,
        operations=entry.operations,
        seconds=time.perf_counter() - start,
        cached=cached,
    )
