"""LLVM IR for one node at a time: every scalar a vector, one lane a walker.

Floating point has XLA's meaning: comparisons with NaN fail (`ne` holds), `max` and `min` pass NaN
on, conversion to an integer clamps and sends NaN to zero. No operation traps or is undefined:
divisors and shifts are guarded. `contract` lets a product and a sum fuse, `nsz` ignores the sign
of zeros; no other liberty is taken.
"""

from collections.abc import Callable

import numpy as np

from mjxwalk.engines.lanes.code import FLAGS, Code
from mjxwalk.engines.lanes.graph import Node
from mjxwalk.engines.lanes.scalars import is_float, is_signed

Operation = Callable[..., str]


def _binary(floats: str, signed: str, unsigned: str | None = None) -> Operation:
    def emit(c: Code, node: Node, dtype: str, x: str, y: str) -> str:
        if is_float(dtype):
            name = f"{floats} {FLAGS}"
        else:
            name = signed if unsigned is None or is_signed(dtype) else unsigned
        return c.let(f"{name} {c.vector(dtype)} {x}, {y}")

    return emit


def _intrinsic(name: str) -> Operation:
    def emit(c: Code, node: Node, dtype: str, *args: str) -> str:
        return c.intrinsic(name, dtype, *args)

    return emit


def _comparison(floats: str, signed: str, unsigned: str) -> Operation:
    def emit(c: Code, node: Node, dtype: str, x: str, y: str) -> str:
        if is_float(dtype):
            return c.let(f"fcmp {floats} {c.vector(dtype)} {x}, {y}")
        return c.let(f"icmp {signed if is_signed(dtype) else unsigned} {c.vector(dtype)} {x}, {y}")

    return emit


def _extreme(op: str) -> Operation:
    """The larger (smaller), and NaN if either is: x86 returns the second operand on NaN."""
    order = "ogt" if op == "max" else "olt"

    def emit(c: Code, node: Node, dtype: str, x: str, y: str) -> str:
        if not is_float(dtype):
            return c.intrinsic(("s" if is_signed(dtype) else "u") + op, dtype, x, y)
        if c.graph.value(node.args[1]) is not None:
            x, y = y, x
        held = c.let(f"fcmp {order} {c.vector(dtype)} {x}, {y}")
        best = c.select(held, x, y, dtype)
        known = c.graph.value(min(node.args, key=lambda n: c.graph.value(n) is None))
        if known is not None and not np.isnan(known):
            return best
        unordered = c.let(f"fcmp uno {c.vector(dtype)} {x}, {x}")
        return c.select(unordered, x, best, dtype)

    return emit


def _negation(c: Code, node: Node, dtype: str, x: str) -> str:
    if is_float(dtype):
        return c.let(f"fneg {c.vector(dtype)} {x}")
    return c.let(f"sub {c.vector(dtype)} zeroinitializer, {x}")


def _absolute(c: Code, node: Node, dtype: str, x: str) -> str:
    if is_float(dtype):
        return c.intrinsic("fabs", dtype, x)
    negative = c.let(f"icmp slt {c.vector(dtype)} {x}, zeroinitializer")
    return c.select(negative, _negation(c, node, dtype, x), x, dtype)


def _invert(c: Code, node: Node, dtype: str, x: str) -> str:
    return c.let(f"xor {c.vector(dtype)} {x}, {c.splat(True if dtype == 'bool' else -1, dtype)}")


def _quotient(op: str) -> Operation:
    """Division that never traps: by zero it gives all ones (remainder: x), as XLA's does."""

    def emit(c: Code, node: Node, dtype: str, x: str, y: str) -> str:
        vector = c.vector(dtype)
        if is_float(dtype):
            return c.let(f"f{op} {FLAGS} {vector} {x}, {y}")
        zero = c.let(f"icmp eq {vector} {y}, zeroinitializer")
        bad = zero
        if is_signed(dtype):
            lowest = c.let(f"icmp eq {vector} {x}, {c.splat(np.iinfo(dtype).min, dtype)}")
            minus = c.let(f"icmp eq {vector} {y}, {c.splat(-1, dtype)}")
            overflow = c.let(f"and {c.vector('bool')} {lowest}, {minus}")
            bad = c.let(f"or {c.vector('bool')} {zero}, {overflow}")
        safe = c.select(bad, c.splat(1, dtype), y, dtype)
        result = c.let(f"{'s' if is_signed(dtype) else 'u'}{op} {vector} {x}, {safe}")
        ones = c.splat(-1 if is_signed(dtype) else np.iinfo(dtype).max, dtype)
        return c.select(zero, ones if op == "div" else x, result, dtype)

    return emit


def _shift(op: str) -> Operation:
    """Shifts of which one by all bits or more leaves nothing but the sign of `ashr`."""

    def emit(c: Code, node: Node, dtype: str, x: str, y: str) -> str:
        vector = c.vector(dtype)
        last = np.dtype(dtype).itemsize * 8 - 1
        known = c.graph.value(node.args[1])
        if known is not None and 0 <= int(known.item()) <= last:
            return c.let(f"{op} {vector} {x}, {y}")
        inside = c.let(f"icmp ule {vector} {y}, {c.splat(last, dtype)}")
        distance = c.select(inside, y, c.splat(last, dtype), dtype)
        moved = c.let(f"{op} {vector} {x}, {distance}")
        return moved if op == "ashr" else c.select(inside, moved, "zeroinitializer", dtype)

    return emit


def _select(c: Code, node: Node, dtype: str, predicate: str, x: str, y: str) -> str:
    return c.select(predicate, x, y, node.dtype)


def _convert(c: Code, node: Node, dtype: str, x: str) -> str:
    source, target = c.vector(dtype), c.vector(node.dtype)
    if dtype == "bool":
        one = c.splat(1, node.dtype)
        return c.select(x, one, c.splat(0, node.dtype), node.dtype)
    if is_float(dtype) and not is_float(node.dtype):
        return _to_integer(c, node, dtype, x)
    if is_float(node.dtype) and not is_float(dtype):
        return c.let(f"{'s' if is_signed(dtype) else 'u'}itofp {source} {x} to {target}")
    before, after = np.dtype(dtype).itemsize, np.dtype(node.dtype).itemsize
    if before == after:
        return x
    if is_float(dtype):
        return c.let(f"{'fpext' if after > before else 'fptrunc'} {source} {x} to {target}")
    widen = "sext" if is_signed(dtype) else "zext"
    return c.let(f"{widen if after > before else 'trunc'} {source} {x} to {target}")


def _to_integer(c: Code, node: Node, dtype: str, x: str) -> str:
    """Truncation; NaN becomes 0, and what is too large or too small the nearest integer."""
    source, target = c.vector(dtype), c.vector(node.dtype)
    limits = np.iinfo(node.dtype)
    ordered = c.let(f"fcmp ord {source} {x}, zeroinitializer")
    inside = c.select(ordered, x, "zeroinitializer", dtype)
    signed = is_signed(node.dtype)
    conversion = "fptosi" if signed else "fptoui"
    if node.data == "within":
        return c.let(f"{conversion} {source} {inside} to {target}")
    least = c.splat(limits.min, dtype)
    low = c.let(f"fcmp ogt {source} {inside}, {least}")
    inside = c.select(low, inside, least, dtype)
    above = c.let(f"fcmp oge {source} {inside}, {c.splat(float(limits.max), dtype)}")
    inside = c.select(above, "zeroinitializer", inside, dtype)
    whole = c.let(f"{conversion} {source} {inside} to {target}")
    return c.select(above, c.splat(limits.max, node.dtype), whole, node.dtype)


def _bitcast(c: Code, node: Node, dtype: str, x: str) -> str:
    return c.let(f"bitcast {c.vector(dtype)} {x} to {c.vector(node.dtype)}")


def _refined(c: Code, x: str, name: str, refine: Callable[[str], tuple[str, str]]) -> str:
    """A 14-bit estimate and one Newton step, except where the step is NaN: at 0 and infinity."""
    vector = c.vector("float32")
    estimate = c.call(
        f"llvm.x86.avx512.{name}14.ps.512", vector, (vector, x), (vector, "zeroinitializer"),
        ("i16", "-1"),
    )  # fmt: skip
    error, better = refine(estimate)
    ordered = c.let(f"fcmp ord {vector} {error}, zeroinitializer")
    return c.select(ordered, better, estimate, "float32")


def _reciprocal(c: Code, node: Node, dtype: str, x: str) -> str:
    vector, one = c.vector(dtype), c.splat(1, dtype)
    if not (c.target.estimates and dtype == "float32"):
        return c.let(f"fdiv {FLAGS} {vector} {one}, {x}")

    def refine(r: str) -> tuple[str, str]:
        minus = c.let(f"fneg {vector} {x}")
        error = c.intrinsic("fma", dtype, minus, r, one)
        return error, c.intrinsic("fma", dtype, error, r, r)

    return _refined(c, x, "rcp", refine)


def _reciprocal_root(c: Code, node: Node, dtype: str, x: str) -> str:
    vector, one = c.vector(dtype), c.splat(1, dtype)
    if not (c.target.estimates and dtype == "float32"):
        return c.let(f"fdiv {FLAGS} {vector} {one}, {c.intrinsic('sqrt', dtype, x)}")

    def refine(r: str) -> tuple[str, str]:  # r (1 + (1 - x r r) / 2)
        product = c.let(f"fmul {vector} {x}, {r}")
        minus = c.let(f"fneg {vector} {product}")
        error = c.intrinsic("fma", dtype, minus, r, one)
        half = c.let(f"fmul {vector} {r}, {c.splat(0.5, dtype)}")
        return error, c.intrinsic("fma", dtype, error, half, r)

    return _refined(c, x, "rsqrt", refine)


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


def emit(code: Code, node_id: int) -> str:
    """Adds a node's instructions; returns the name of its value."""
    node = code.graph.nodes[node_id]
    operand = node.args[0] if node.op != "select" else node.args[1]
    args = [code.value(arg) for arg in node.args]
    return OPERATIONS[node.op](code, node, code.graph.nodes[operand].dtype, *args)
