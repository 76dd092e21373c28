"""From a jaxpr to the scalar graph: an interpreter whose numbers are nodes.

An array whose numbers are known while tracing stays a numpy array (`Known`); most of a model is
that, and all of it folds away. Any other is an array of node ids (`Nodes`), so that every
operation that only moves numbers about is numpy's own, applied to the ids. What each primitive
does is in the tables of `primitives`.
"""

import dataclasses
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from mjxwalk.engines.lanes.errors import CannotCompileError
from mjxwalk.engines.lanes.frontend import memory
from mjxwalk.engines.lanes.frontend.key_types import implementation, is_key_type, wrapped
from mjxwalk.engines.lanes.frontend.memory import ARGUMENT
from mjxwalk.engines.lanes.ir.graph import OUTSIDE, Array, Graph, LoopId
from mjxwalk.engines.lanes.ir.semantics import evaluate
from mjxwalk.engines.lanes.ir.simplify import simplifying

NUMBERS = tuple("bool int8 int16 int32 int64 uint8 uint16 uint32 uint64 float32 float64".split())

Equation = Any  # jax.extend.core.JaxprEqn; its parts are untyped, and read in this package only
Jaxpr = Any


@dataclasses.dataclass(frozen=True)
class Known:
    """An array of numbers known while tracing."""

    array: Array

    @property
    def dtype(self) -> str:
        """The type of the numbers."""
        return self.array.dtype.name


@dataclasses.dataclass(frozen=True)
class Nodes:
    """An array of numbers that each walker computes: ids of nodes, all of one type."""

    array: Array
    dtype: str


@dataclasses.dataclass(frozen=True)
class Keys:
    """Random keys: the words that they are made of, uint32[..., words], and JAX's type of them."""

    words: "Known | Nodes"
    type: Any

    @property
    def dtype(self) -> str:
        """The type of the keys."""
        return self.type.name

    @property
    def array(self) -> Array:
        """What is shaped as the keys are."""
        return self.words.array[..., 0]


Value = Known | Nodes | Keys
Params = dict[str, Any]  # of a primitive
Handler = Callable[["Interpreter", Params, list[Value]], list[Value]]


class Interpreter:
    """Interprets jaxprs into one graph.

    Attributes:
      region: the loop that is being traced.
      guard: node of the condition under which the traced code matters to a walker, or None.
    """

    def __init__(self, handlers: Mapping[str, Handler]) -> None:
        self.build = simplifying(Graph())
        self.region: LoopId = OUTSIDE
        self.guard: int | None = None
        self._handlers = handlers

    @property
    def graph(self) -> Graph:
        """The graph that grows."""
        return self.build.graph

    def run(self, jaxpr: Jaxpr, consts: Sequence[Any], args: Sequence[Value]) -> list[Value]:
        """Returns the outputs of a jaxpr for these values of its inputs."""
        values: dict[Any, Value] = {}
        values.update(zip(jaxpr.constvars, map(self.known, consts), strict=True))
        values.update(zip(jaxpr.invars, args, strict=True))

        def read(atom: Any) -> Value:
            if hasattr(atom, "val"):  # a literal, whose value may be a plain Python number
                return Known(np.asarray(atom.val, atom.aval.dtype))
            return values[atom]

        for equation in jaxpr.eqns:
            outputs = self._equation(equation, [read(atom) for atom in equation.invars])
            values.update(zip(equation.outvars, outputs, strict=True))
        return [read(atom) for atom in jaxpr.outvars]

    def call(self, closed: Jaxpr, args: Sequence[Value]) -> list[Value]:
        """Returns the outputs of a jaxpr that carries its own constants."""
        if hasattr(closed, "consts"):
            return self.run(closed.jaxpr, closed.consts, args)
        return self.run(closed, (), args)

    def _equation(self, equation: Equation, inputs: list[Value]) -> list[Value]:
        try:
            return self._outputs(equation, inputs)
        except CannotCompileError:
            raise
        except Refusal as refusal:
            reason = refusal
        except Exception as error:
            reason = Refusal(f"meets a fault of the engine there ({type(error).__name__}: {error})")
            reason.__cause__ = error
        reason.primitive = reason.primitive or equation.primitive.name
        where = _line(equation)
        if not where:  # inside a function of JAX's own: the equation that calls it has a line
            raise reason
        raise reason.error(where) from reason.__cause__

    def _outputs(self, equation: Equation, inputs: list[Value]) -> list[Value]:
        avals = [variable.aval for variable in equation.outvars]
        if avals and all(aval.size == 0 for aval in avals):
            return [self.zeros(aval.shape, aval.dtype) for aval in avals]
        for aval in avals:
            if aval.dtype.name not in NUMBERS and not is_key_type(aval.dtype):
                raise Refusal(f"makes {aval.dtype.name} numbers, which it does not compute with")
        name = equation.primitive.name
        handler = self._handlers.get(name)
        keys = [value for value in inputs if isinstance(value, Keys)]
        if (keys or handler is None) and all(map(is_known, inputs)) and not _holds_jaxprs(equation):
            return self._eagerly(equation, inputs)
        if handler is None:
            raise Refusal("is not known to it")
        if keys and not (name.startswith("random_") or _holds_jaxprs(equation)):
            return self._by_words(handler, equation, inputs)
        return handler(self, equation.params, inputs)

    def _by_words(self, handler: "Handler", equation: Equation, inputs: list[Value]) -> list[Value]:
        """Returns what a handler that only moves numbers makes of each word of random keys."""

        def output(number: int) -> Value:
            return self.by_words(lambda *x: handler(self, equation.params, [*x])[number], *inputs)

        return [output(number) for number in range(len(equation.outvars))]

    def _eagerly(self, equation: Equation, inputs: list[Value]) -> list[Value]:
        """Lets JAX compute what has no handler here and depends on no walker."""
        import jax

        with jax.ensure_compile_time_eval():
            arrays = [
                wrapped(value.words.array, value.type)
                if isinstance(value, Keys)
                else jax.numpy.asarray(value.array)
                for value in inputs
            ]
            outputs = equation.primitive.bind(*arrays, **equation.params)
        many = equation.primitive.multiple_results
        return [self.known(output) for output in (outputs if many else [outputs])]

    def known(self, value: Any) -> Known | Keys:
        """Returns numbers or random keys known while tracing."""
        import jax

        if isinstance(value, jax.Array) and is_key_type(value.dtype):
            return Keys(Known(np.asarray(jax.random.key_data(value))), value.dtype)
        return Known(np.asarray(value))

    def zeros(self, shape: Sequence[int], dtype: Any) -> Known | Keys:
        """Returns an array of zeros of a type of JAX's."""
        if is_key_type(dtype):
            words = implementation(dtype).key_shape
            return Keys(Known(np.zeros((*shape, *words), np.uint32)), dtype)
        return Known(np.zeros(shape, dtype))

    def by_words(self, function: Callable[..., Value], *values: Value) -> Value:
        """Returns what moves numbers or chooses among them, done to each word of random keys."""
        like = next((value for value in values if isinstance(value, Keys)), None)
        if like is None:
            return function(*values)
        made: list[Value] = []
        for n in range(like.words.array.shape[-1]):
            words = [
                self.move(lambda x, n=n: x[..., n], value.words)
                if isinstance(value, Keys)
                else value
                for value in values
            ]
            made.append(function(*words))
        stacked = self.move(lambda *x: np.stack(x, -1), *made)
        assert not isinstance(stacked, Keys)
        return Keys(stacked, like.type)

    def nodes(self, value: Value) -> Array:
        """Returns the ids of an array's numbers, as nodes of the graph."""
        if isinstance(value, Keys):
            raise Refusal("needs random keys as numbers; take jax.random.key_data of them")
        if isinstance(value, Known):
            flat = [self.graph.constant(number) for number in value.array.ravel()]
            return np.array(flat, np.int64).reshape(value.array.shape)
        ids = value.array
        if ids.size == 0 or int(ids.max()) < ARGUMENT:
            return ids
        flat = [memory.node(self.graph, number, value.dtype) for number in ids.ravel().tolist()]
        return np.array(flat, np.int64).reshape(ids.shape)

    def folded(self, ids: Array, dtype: str) -> Known | Nodes:
        """Returns an array of ids, as known numbers if every one of them is a constant."""
        values = [self.graph.value(number) for number in ids.ravel().tolist()]
        if all(value is not None for value in values):
            return Known(np.array(values, dtype).reshape(ids.shape))
        return Nodes(ids, dtype)

    def apply(self, op: str, dtype: str, *values: Value) -> Value:
        """Returns a scalar operation applied element by element; scalars stretch."""
        if all(isinstance(value, Known) for value in values):
            return Known(evaluate(op, dtype, *(value.array for value in values)))
        stays = self._in_memory(op, dtype, values)
        if stays is not None:
            return Nodes(stays, dtype)
        ids = np.broadcast_arrays(*map(self.nodes, values))
        make = self.build.make
        flat = [
            make(op, dtype, args) for args in zip(*(i.ravel().tolist() for i in ids), strict=True)
        ]
        return Nodes(np.array(flat, np.int64).reshape(ids[0].shape), dtype)

    def _in_memory(self, op: str, dtype: str, values: Sequence[Value]) -> Array | None:
        """Returns the ids of an operation on arrays that a loop computed, None of any other."""
        graph = self.graph
        if not any(isinstance(v, Nodes) and memory.is_array(graph, v.array) for v in values):
            return None
        ids = (v.array if isinstance(v, Nodes) else self.nodes(v) for v in values)
        dtypes = [value.dtype for value in values]
        return memory.elementwise(graph, op, dtype, np.broadcast_arrays(*ids), dtypes)

    def move(self, mover: Callable[..., Array], *values: Value) -> Value:
        """Returns what numpy makes of arrays whose numbers are only moved, never computed with."""
        dtype = values[0].dtype
        if len(values) == 1 or all(isinstance(value, Known) for value in values):
            moved = np.asarray(mover(*(value.array for value in values)))
            return Known(moved) if isinstance(values[0], Known) else Nodes(moved, dtype)
        ids = (v.array if isinstance(v, Nodes) else self.nodes(v) for v in values)
        return Nodes(np.asarray(mover(*ids)), dtype)

    @contextmanager
    def inside(self, *, region: LoopId | None = None, guard: int | None = None) -> Generator[None]:
        """Traces what follows inside a loop, or where only some walkers take part."""
        before = self.region, self.guard
        if region is not None:
            self.region, self.guard = region, None
        if guard is not None:
            both = guard if self.guard is None else self.build.same("and", self.guard, guard)
            self.guard = both
        try:
            yield
        finally:
            self.region, self.guard = before


class Refusal(Exception):
    """Raised by a handler that cannot do what is asked of it; the message ends the sentence."""

    primitive = ""

    def error(self, where: str) -> CannotCompileError:
        """Returns the error that names the primitive and the line of user code that made it."""
        return CannotCompileError(
            f"the lanes engine cannot compile `{self.primitive}` from {where}: it {self}; "
            "use --engine mjx, which runs anything that JAX can trace"
        )


def _holds_jaxprs(equation: Equation) -> bool:
    """Returns whether an equation is a call, a branch or a loop."""
    params = (p if isinstance(p, tuple) else (p,) for p in equation.params.values())
    return any(hasattr(part, "jaxpr") or hasattr(part, "eqns") for p in params for part in p)


def is_known(value: Value) -> bool:
    """Returns whether all numbers of a value are known while tracing."""
    return isinstance(value.words if isinstance(value, Keys) else value, Known)


def _line(equation: Equation) -> str:
    """Returns the file, line and function that made an equation, or nothing if JAX forgot."""
    from jax._src import source_info_util  # no public way to a traced line; JAX 0.10

    return source_info_util.summarize(equation.source_info)
