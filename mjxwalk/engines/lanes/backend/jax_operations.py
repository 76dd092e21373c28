"""The other code generator: a program as JAX operations, every scalar an array over walkers.

XLA compiles these for whatever it knows: since all operations are element by element on arrays of
one shape, it can fuse a step into few kernels. Arguments keep all numbers of a walker in one array,
[number, walker], and so does what is computed once before the loop: reading a row of it costs
nothing inside a kernel, while kernels can take only so many arrays (XLA ends a fusion at 96).
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from mjxwalk.engines.lanes.ir.arrays import IN_MEMORY, View
from mjxwalk.engines.lanes.ir.graph import Node
from mjxwalk.engines.lanes.ir.program import Program, RotatedLoop, Step

OPERATIONS: dict[str, Callable[..., jax.Array]] = {
    "add": lax.add, "sub": lax.sub, "mul": lax.mul, "div": lax.div, "rem": lax.rem,
    "neg": lax.neg, "abs": lax.abs, "max": lax.max, "min": lax.min, "pow": lax.pow,
    "sqrt": lax.sqrt, "rsqrt": lax.rsqrt, "recip": lambda x: lax.div(lax.full_like(x, 1), x),
    "floor": lax.floor, "ceil": lax.ceil,
    "rint": lambda x: lax.round(x, lax.RoundingMethod.TO_NEAREST_EVEN),
    "lt": lax.lt, "le": lax.le, "eq": lax.eq, "ne": lax.ne,
    "and": lax.bitwise_and, "or": lax.bitwise_or, "xor": lax.bitwise_xor, "not": lax.bitwise_not,
    "shl": lax.shift_left, "shr": lax.shift_right_logical, "sar": lax.shift_right_arithmetic,
    "select": lax.select, "cbrt": lax.cbrt, "erf": lax.erf, "erfc": lax.erfc,
    "erf_inv": lax.erf_inv,
    "sin": lax.sin, "cos": lax.cos, "tan": lax.tan, "asin": lax.asin, "acos": lax.acos,
    "atan": lax.atan, "atan2": lax.atan2, "sinh": lax.sinh, "cosh": lax.cosh, "tanh": lax.tanh,
    "asinh": lax.asinh, "acosh": lax.acosh, "atanh": lax.atanh, "exp": lax.exp, "exp2": lax.exp2,
    "expm1": lax.expm1, "log": lax.log, "log1p": lax.log1p, "logistic": lax.logistic,
}  # fmt: skip


def outputs(
    program: Program, inputs: Sequence[jax.Array], shared: Sequence[bool], size: int
) -> list[jax.Array]:
    """Returns every output number of a program for all walkers, [walker] each.

    Args:
      inputs: [number, walker], or [number] where all walkers share them.
      shared: which of the inputs are.
      size: how many walkers there are.
    """
    arrays = _Arrays(program, inputs, shared, size)
    everybody = jnp.ones(size, bool)
    arrays.run(program.prologue, everybody)
    if program.loop is not None:
        arrays.loop(program.loop, everybody)
    arrays.run(program.epilogue, everybody)
    return [arrays.spread(arrays.value(node)) for node in program.outputs]


class _Arrays:
    """What has been computed so far: arrays over walkers, or scalars where all are alike."""

    def __init__(
        self, program: Program, inputs: Sequence[jax.Array], shared: Sequence[bool], size: int
    ) -> None:
        self.graph = program.graph
        self.inputs = inputs
        self.shared = shared
        self.size = size
        self.values: dict[int, jax.Array] = {}

    def value(self, node_id: int) -> Any:
        """Returns a node's value: a number if it is known, else an array."""
        known = self.graph.value(node_id)
        if known is not None:
            return known
        node = self.graph.nodes[node_id]
        if node.op == "input":  # sliced where it is used, and never held
            argument, offset = node.data
            return self.inputs[argument][offset]
        return self.values[node_id]

    def spread(self, value: Any) -> jax.Array:
        """Returns a value as an array over walkers."""
        return lax.broadcast(value, (self.size,)) if np.ndim(value) == 0 else value

    def run(self, steps: Iterable[Step], active: jax.Array) -> None:
        """Computes steps; loops run for the walkers that are active."""
        for step in steps:
            if isinstance(step, RotatedLoop):
                self.loop(step, active)
            elif self.graph.nodes[step].op != "input":
                self.values[step] = self.compute(self.graph.nodes[step])

    def compute(self, node: Node) -> jax.Array:
        """Returns what a node is for all walkers."""
        args = [self.value(arg) for arg in node.args]
        if node.op in IN_MEMORY:
            return self.array(node, args)
        if node.op == "inside":
            return args[0]
        if node.op == "element":
            return args[0][node.data]
        if any(np.ndim(arg) for arg in args):
            args = [self.spread(arg) for arg in args]
        if node.op == "lookup":
            return _read(jnp.asarray(self.graph.tables[node.data]), args[0])
        if node.op == "load":
            return self.load(node.data, args[0])
        return _apply(node.op, node.dtype, args)

    def array(self, node: Node, args: Sequence[Any]) -> jax.Array:
        """Returns the numbers of an array for all walkers, [number, walker]."""
        if node.op == "array":
            return jnp.stack([self.spread(arg) for arg in args])
        shape: tuple[int, ...] = node.data.shape
        if node.op == "product":
            rows, columns, terms = shape
            left = self.viewed(node.data.left, (rows, terms), args)
            right = self.viewed(node.data.right, (columns, terms), args)
            made = jnp.einsum("ikw,jkw->ijw", left, right)
        else:
            reads = (self.viewed(view, shape, args) for view in node.data.operands)
            made = _apply(node.data.op, node.dtype, list(reads))
        return made.reshape(-1, self.size)

    def viewed(self, view: View, shape: tuple[int, ...], args: Sequence[Any]) -> jax.Array:
        """Returns the numbers that a view reads, [index..., walker]."""
        if view.kind == "value":
            return jnp.broadcast_to(args[int(view.source)], (*shape, self.size))
        axes = np.indices(shape)
        places = view.first + sum(s * axis for s, axis in zip(view.strides, axes, strict=True))
        if view.kind == "table":
            found = jnp.asarray(self.graph.tables[str(view.source)])[places]
        elif view.kind == "input":
            found = self.inputs[int(view.source)][places]
        else:
            return args[int(view.source)][places]
        return jnp.broadcast_to(found.reshape(*shape, -1), (*shape, self.size))

    def load(self, argument: int, index: jax.Array) -> jax.Array:
        """Returns the number at a computed place of an argument, a walker's own or shared."""
        array = self.inputs[argument]
        if self.shared[argument]:
            return _read(array, index)
        places = self.spread(index) * self.size + jnp.arange(self.size, dtype=index.dtype)
        return _read(array.ravel(), places)

    def loop(self, loop: RotatedLoop, active: jax.Array) -> None:
        """Runs a loop until no active walker wants another step, and holds those that do not."""
        places = list(loop.initial)
        start = tuple(self.spread(self.value(node)) for node in loop.initial.values())
        first = active & self.spread(self.value(loop.first_test))
        outer = dict(self.values)
        packed = self._packed(loop)

        def step(state: Any) -> Any:
            wanting, held = state
            self.values = outer | self._unpacked(packed)
            self.values.update(zip((loop.carries[place] for place in places), held, strict=True))
            self.run(loop.body, wanting)
            new = (self.spread(self.value(loop.following[place])) for place in places)
            kept = tuple(lax.select(wanting, *pair) for pair in zip(new, held, strict=True))
            return wanting & self.spread(self.value(loop.next_test)), kept

        _, ended = lax.while_loop(lambda state: jnp.any(state[0]), step, (first, start))
        self.values = outer
        for place, value in zip(places, ended, strict=True):
            data = (loop.id, place)
            found = self.graph.find("result", value.dtype.name, (), data)
            if found is not None:
                self.values[found] = value

    def _packed(self, loop: RotatedLoop) -> list[tuple[list[int], jax.Array]]:
        """Returns what a loop reads from outside, the arrays of one type as rows of one."""
        kinds: dict[str, list[int]] = {}
        for node in sorted(loop.external_inputs):
            if node in self.values and self.values[node].ndim == 1:
                kinds.setdefault(self.values[node].dtype.name, []).append(node)
        return [(nodes, jnp.stack([self.values[n] for n in nodes])) for nodes in kinds.values()]

    def _unpacked(self, packed: list[tuple[list[int], jax.Array]]) -> dict[int, jax.Array]:
        return {node: rows[n] for nodes, rows in packed for n, node in enumerate(nodes)}


def _apply(op: str, dtype: str, args: Sequence[Any]) -> jax.Array:
    """Returns a scalar operation on arrays of one shape."""
    if op == "convert":
        return lax.convert_element_type(args[0], np.dtype(dtype))
    if op == "bitcast":
        return lax.bitcast_convert_type(args[0], np.dtype(dtype))
    return OPERATIONS[op](*args)


def _read(array: jax.Array, index: jax.Array) -> jax.Array:
    """Returns array[index]; what lies outside becomes the nearest end."""
    return array.at[index].get(mode="clip")
