"""LLVM IR for one node at a time: every scalar a vector, one lane a walker.

Floating point has XLA's meaning: comparisons with NaN fail (`ne` holds), `max` and `min` pass NaN
on, conversion to an integer clamps and sends NaN to zero. No operation traps or is undefined:
divisors and shifts are guarded. `contract` lets a product and a sum fuse, `nsz` ignores the sign
of zeros; no other liberty is taken.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from mjxwalk.engines.lanes.backend.writer import FLAGS, Writer
from mjxwalk.engines.lanes.ir.arrays import Elementwise
from mjxwalk.engines.lanes.ir.graph import Graph, Node
from mjxwalk.engines.lanes.ir.lowering import LoweringBuilder
from mjxwalk.engines.lanes.ir.semantics import is_float, is_signed


class Context(NamedTuple):
    """What an instruction depends on besides the type and the names of its operands.

    Attributes:
      dtype: of the result.
      known: value of each operand; None where walkers compute it.
      in_range: whether a conversion needs no clamp.
    """

    dtype: str
    known: tuple[Any, ...]
    in_range: bool


Operation = Callable[..., str]  # of the writer, a context, the operands' type and their names


def _binary(floats: str, signed: str, unsigned: str | None = None) -> Operation:
    def emit(w: Writer, context: Context, dtype: str, x: str, y: str) -> str:
        if is_float(dtype):
            name = f"{floats} {FLAGS}"
        else:
            name = signed if unsigned is None or is_signed(dtype) else unsigned
        return w.let(f"{name} {w.vector(dtype)} {x}, {y}")

    return emit


def _intrinsic(name: str) -> Operation:
    def emit(w: Writer, context: Context, dtype: str, *args: str) -> str:
        return w.intrinsic(name, dtype, *args)

    return emit


def _comparison(floats: str, signed: str, unsigned: str) -> Operation:
    def emit(w: Writer, context: Context, dtype: str, x: str, y: str) -> str:
        if is_float(dtype):
            return w.let(f"fcmp {floats} {w.vector(dtype)} {x}, {y}")
        return w.let(f"icmp {signed if is_signed(dtype) else unsigned} {w.vector(dtype)} {x}, {y}")

    return emit


def _extreme(op: str) -> Operation:
    """The larger (smaller), and NaN if either is: x86 returns the second operand on NaN."""
    order = "ogt" if op == "max" else "olt"

    def emit(w: Writer, context: Context, dtype: str, x: str, y: str) -> str:
        if not is_float(dtype):
            return w.intrinsic(("s" if is_signed(dtype) else "u") + op, dtype, x, y)
        if w.target.extremes_pass_nan:
            return w.intrinsic(f"{op}imum", dtype, x, y)
        if context.known[1] is not None:
            x, y = y, x
        held = w.let(f"fcmp {order} {w.vector(dtype)} {x}, {y}")
        best = w.select(held, x, y, dtype)
        known = next((value for value in context.known if value is not None), None)
        if known is not None and not np.isnan(known):
            return best
        unordered = w.let(f"fcmp uno {w.vector(dtype)} {x}, {x}")
        return w.select(unordered, x, best, dtype)

    return emit


def _negation(w: Writer, context: Context, dtype: str, x: str) -> str:
    if is_float(dtype):
        return w.let(f"fneg {w.vector(dtype)} {x}")
    return w.let(f"sub {w.vector(dtype)} zeroinitializer, {x}")


def _absolute(w: Writer, context: Context, dtype: str, x: str) -> str:
    if is_float(dtype):
        return w.intrinsic("fabs", dtype, x)
    negative = w.let(f"icmp slt {w.vector(dtype)} {x}, zeroinitializer")
    return w.select(negative, _negation(w, context, dtype, x), x, dtype)


def _invert(w: Writer, context: Context, dtype: str, x: str) -> str:
    return w.let(f"xor {w.vector(dtype)} {x}, {w.splat(True if dtype == 'bool' else -1, dtype)}")


def _quotient(op: str) -> Operation:
    """Division that never traps: by zero it gives all ones (remainder: x), as XLA's does."""

    def emit(w: Writer, context: Context, dtype: str, x: str, y: str) -> str:
        vector = w.vector(dtype)
        if is_float(dtype):
            return w.let(f"f{op} {FLAGS} {vector} {x}, {y}")
        zero = w.let(f"icmp eq {vector} {y}, zeroinitializer")
        bad = zero
        if is_signed(dtype):
            lowest = w.let(f"icmp eq {vector} {x}, {w.splat(np.iinfo(dtype).min, dtype)}")
            minus = w.let(f"icmp eq {vector} {y}, {w.splat(-1, dtype)}")
            overflow = w.let(f"and {w.vector('bool')} {lowest}, {minus}")
            bad = w.let(f"or {w.vector('bool')} {zero}, {overflow}")
        safe = w.select(bad, w.splat(1, dtype), y, dtype)
        result = w.let(f"{'s' if is_signed(dtype) else 'u'}{op} {vector} {x}, {safe}")
        ones = w.splat(-1 if is_signed(dtype) else np.iinfo(dtype).max, dtype)
        return w.select(zero, ones if op == "div" else x, result, dtype)

    return emit


def _shift(op: str) -> Operation:
    """Shifts of which one by all bits or more leaves nothing but the sign of `ashr`."""

    def emit(w: Writer, context: Context, dtype: str, x: str, y: str) -> str:
        vector = w.vector(dtype)
        last = np.dtype(dtype).itemsize * 8 - 1
        known = context.known[1]
        if known is not None and 0 <= int(known.item()) <= last:
            return w.let(f"{op} {vector} {x}, {y}")
        inside = w.let(f"icmp ule {vector} {y}, {w.splat(last, dtype)}")
        distance = w.select(inside, y, w.splat(last, dtype), dtype)
        moved = w.let(f"{op} {vector} {x}, {distance}")
        return moved if op == "ashr" else w.select(inside, moved, "zeroinitializer", dtype)

    return emit


def _select(w: Writer, context: Context, dtype: str, predicate: str, x: str, y: str) -> str:
    return w.select(predicate, x, y, context.dtype)


def _convert(w: Writer, context: Context, dtype: str, x: str) -> str:
    source, target = w.vector(dtype), w.vector(context.dtype)
    if dtype == "bool":
        one = w.splat(1, context.dtype)
        return w.select(x, one, w.splat(0, context.dtype), context.dtype)
    if is_float(dtype) and not is_float(context.dtype):
        return _to_integer(w, context, dtype, x)
    if is_float(context.dtype) and not is_float(dtype):
        return w.let(f"{'s' if is_signed(dtype) else 'u'}itofp {source} {x} to {target}")
    before, after = np.dtype(dtype).itemsize, np.dtype(context.dtype).itemsize
    if before == after:
        return x
    if is_float(dtype):
        return w.let(f"{'fpext' if after > before else 'fptrunc'} {source} {x} to {target}")
    widen = "sext" if is_signed(dtype) else "zext"
    return w.let(f"{widen if after > before else 'trunc'} {source} {x} to {target}")


def _to_integer(w: Writer, context: Context, dtype: str, x: str) -> str:
    """Truncation; NaN becomes 0, and what is too large or too small the nearest integer."""
    source, target = w.vector(dtype), w.vector(context.dtype)
    limits = np.iinfo(context.dtype)
    ordered = w.let(f"fcmp ord {source} {x}, zeroinitializer")
    inside = w.select(ordered, x, "zeroinitializer", dtype)
    signed = is_signed(context.dtype)
    conversion = "fptosi" if signed else "fptoui"
    if context.in_range:
        return w.let(f"{conversion} {source} {inside} to {target}")
    least = w.splat(limits.min, dtype)
    low = w.let(f"fcmp ogt {source} {inside}, {least}")
    inside = w.select(low, inside, least, dtype)
    above = w.let(f"fcmp oge {source} {inside}, {w.splat(float(limits.max), dtype)}")
    inside = w.select(above, "zeroinitializer", inside, dtype)
    whole = w.let(f"{conversion} {source} {inside} to {target}")
    return w.select(above, w.splat(limits.max, context.dtype), whole, context.dtype)


def _bitcast(w: Writer, context: Context, dtype: str, x: str) -> str:
    return w.let(f"bitcast {w.vector(dtype)} {x} to {w.vector(context.dtype)}")


def _refined(w: Writer, x: str, name: str, refine: Callable[[str], tuple[str, str]]) -> str:
    """A 14-bit estimate and one Newton step, except where the step is NaN: at 0 and infinity."""
    vector = w.vector("float32")
    estimate = w.call(
        f"llvm.x86.avx512.{name}14.ps.512", vector, (vector, x), (vector, "zeroinitializer"),
        ("i16", "-1"),
    )  # fmt: skip
    error, better = refine(estimate)
    ordered = w.let(f"fcmp ord {vector} {error}, zeroinitializer")
    return w.select(ordered, better, estimate, "float32")


def _reciprocal(w: Writer, context: Context, dtype: str, x: str) -> str:
    vector, one = w.vector(dtype), w.splat(1, dtype)
    if not (w.target.estimates and dtype == "float32"):
        return w.let(f"fdiv {FLAGS} {vector} {one}, {x}")

    def refine(r: str) -> tuple[str, str]:
        minus = w.let(f"fneg {vector} {x}")
        error = w.intrinsic("fma", dtype, minus, r, one)
        return error, w.intrinsic("fma", dtype, error, r, r)

    return _refined(w, x, "rcp", refine)


def _reciprocal_root(w: Writer, context: Context, dtype: str, x: str) -> str:
    vector, one = w.vector(dtype), w.splat(1, dtype)
    if not (w.target.estimates and dtype == "float32"):
        return w.let(f"fdiv {FLAGS} {vector} {one}, {w.intrinsic('sqrt', dtype, x)}")

    def refine(r: str) -> tuple[str, str]:  # r (1 + (1 - x r r) / 2)
        product = w.let(f"fmul {vector} {x}, {r}")
        minus = w.let(f"fneg {vector} {product}")
        error = w.intrinsic("fma", dtype, minus, r, one)
        half = w.let(f"fmul {vector} {r}, {w.splat(0.5, dtype)}")
        return error, w.intrinsic("fma", dtype, error, half, r)

    return _refined(w, x, "rsqrt", refine)


OPERATIONS: dict[str, Operation] = {
    "add": _binary("fadd", "add"),
    "sub": _binary("fsub", "sub"),
    "mul": _binary("fmul", "mul"),
    "and": _binary("", "and"),
    "or": _binary("", "or"),
    "xor": _binary("", "xor"),
    "div": _quotient("div"),
    "rem": _quotient("rem"),
    "max": _extreme("max"),
    "min": _extreme("min"),
    "lt": _comparison("olt", "slt", "ult"),
    "le": _comparison("ole", "sle", "ule"),
    "eq": _comparison("oeq", "eq", "eq"),
    "ne": _comparison("une", "ne", "ne"),
    "shl": _shift("shl"),
    "shr": _shift("lshr"),
    "sar": _shift("ashr"),
    "sqrt": _intrinsic("sqrt"),
    "floor": _intrinsic("floor"),
    "ceil": _intrinsic("ceil"),
    "rint": _intrinsic("rint"),
    "fma": _intrinsic("fma"),
    "neg": _negation,
    "abs": _absolute,
    "not": _invert,
    "select": _select,
    "convert": _convert,
    "bitcast": _bitcast,
    "recip": _reciprocal,
    "rsqrt": _reciprocal_root,
}


def emit(w: Writer, graph: Graph, node: Node, args: Sequence[str]) -> str:
    """Adds a node's instructions; returns the name of its value."""
    operand = graph.nodes[node.args[1 if node.op == "select" else 0]]
    known = tuple(map(graph.value, node.args))
    context = Context(node.dtype, known, in_range=node.data == "within")
    return OPERATIONS[node.op](w, context, operand.dtype, *args)


def written_out(w: Writer, each: Elementwise, dtype: str, operands: Sequence[str]) -> str:
    """Adds an operation in terms of what processors have; returns the name of its value."""
    graph = Graph()
    args = tuple(
        graph.add("input", kind, (), (number, 0)) for number, kind in enumerate(each.dtypes)
    )
    last = LoweringBuilder(graph).make(each.op, dtype, args)
    names = dict(zip(args, operands, strict=True))
    for node_id, node in enumerate(graph.nodes):
        value = graph.value(node_id)
        if value is not None:
            names[node_id] = w.splat(value, node.dtype)
        elif node_id not in names:
            names[node_id] = emit(w, graph, node, [names[arg] for arg in node.args])
    return names[last]
