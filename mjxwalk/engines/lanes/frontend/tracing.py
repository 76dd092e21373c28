"""From a Python function of one walker to its scalar graph."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import jax
import numpy as np

from mjxwalk.engines.lanes.errors import CannotCompileError
from mjxwalk.engines.lanes.frontend.interpreter import (
    ARGUMENT,
    NUMBERS,
    Handler,
    Interpreter,
    Keys,
    Nodes,
    Refusal,
    Value,
)
from mjxwalk.engines.lanes.frontend.key_types import is_key_type, key_type
from mjxwalk.engines.lanes.frontend.primitives import (
    bit_patterns,
    control_flow,
    data_movement,
    elementwise,
    indexing,
    linear_algebra,
    random_keys,
    reductions,
    sorting,
)
from mjxwalk.engines.lanes.ir.graph import Graph
from mjxwalk.engines.lanes.ir.signature import Argument, Result

HANDLERS: dict[str, Handler] = {
    **data_movement.HANDLERS,
    **elementwise.HANDLERS,
    **indexing.HANDLERS,
    **reductions.HANDLERS,
    **linear_algebra.HANDLERS,
    **sorting.HANDLERS,
    **random_keys.HANDLERS,
    **bit_patterns.HANDLERS,
    **control_flow.HANDLERS,
}

# JAX remembers traces by the function's object and by contexts like this one.
_TRACE = jax.make_user_context(0)
_TRACES = itertools.count(1)


class Traced(NamedTuple):
    """A function as a scalar graph.

    Attributes:
      outputs: node of every output number, in order.
      results: what the outputs make up, in the order of the tree's leaves.
      tree: of what the function returns.
    """

    graph: Graph
    outputs: tuple[int, ...]
    results: tuple[Result, ...]
    tree: Any


def own_arguments(args: tuple[Any, ...]) -> tuple[Any, list[Argument]]:
    """Returns the tree of a function's positional arguments, and its leaves as a walker's own."""
    leaves, tree = jax.tree.flatten((args, {}))
    avals = [jax.typeof(leaf) for leaf in leaves]
    return tree, [Argument(tuple(a.shape), a.dtype.name, a.weak_type, False) for a in avals]


def trace(
    function: Callable[..., Any],
    tree: Any,
    arguments: Sequence[Argument],
    *,
    anew: bool = True,
    interpreter: Callable[[Mapping[str, Handler]], Interpreter] = Interpreter,
) -> Traced:
    """Returns the scalar graph of a function of one walker.

    Args:
      tree: of the function's positional and keyword arguments.
      anew: whether to use nothing that JAX traced before, such as the body of a scan, since a
        global or an attribute that it reads may have changed.
      interpreter: makes what interprets the function.

    Raises:
      CannotCompileError: the function uses what the engine has no code for.
    """
    leaves = list(map(_leaf, arguments))

    def flat(*leaves: Any) -> Any:
        args, kwargs = jax.tree.unflatten(tree, leaves)
        return function(*args, **kwargs)

    with _TRACE(next(_TRACES) if anew else 0):
        jaxpr, shapes = jax.make_jaxpr(flat, return_shape=True)(*leaves)
    interpret = interpreter(HANDLERS)
    for a in [*arguments, *jax.tree.leaves(shapes)]:
        if str(a.dtype) not in NUMBERS:
            if is_key_type(a.dtype):
                raise CannotCompileError(
                    "the lanes engine returns numbers, and this function returns random keys; "
                    "return jax.random.key_data of them"
                )
            raise CannotCompileError(
                f"the lanes engine takes and returns numbers of the types {', '.join(NUMBERS)}, "
                f"got {a.dtype}; use --engine mjx"
            )
    inputs = [_input(number, argument) for number, argument in enumerate(arguments)]
    try:
        values = interpret.run(jaxpr.jaxpr, jaxpr.consts, inputs)
    except Refusal as refusal:
        raise refusal.error("a line that JAX did not record") from refusal.__cause__
    outputs = tuple(node for v in values for node in interpret.nodes(v).ravel().tolist())
    results = tuple(Result(tuple(v.array.shape), v.dtype) for v in values)
    return Traced(interpret.graph, outputs, results, jax.tree.structure(shapes))


def _leaf(argument: Argument) -> jax.ShapeDtypeStruct:
    """Returns what JAX traces an argument as."""
    if argument.generator:
        kind = key_type(argument.generator)
        return jax.ShapeDtypeStruct(argument.shape[:-1], kind)
    dtype = np.dtype(argument.dtype)
    return jax.ShapeDtypeStruct(argument.shape, dtype, weak_type=argument.weak_type)


def _input(number: int, argument: Argument) -> Value:
    """Returns the nodes of an argument, which are made when they are first read."""
    places = ARGUMENT * (number + 1) + np.arange(argument.size)
    nodes = Nodes(places.reshape(argument.shape), argument.dtype)
    if argument.generator:
        return Keys(nodes, key_type(argument.generator))
    return nodes
