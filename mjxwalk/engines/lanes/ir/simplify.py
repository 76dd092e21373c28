"""Simplification while the graph grows: folded constants, and identities of arithmetic.

The rules are exact, or exact but for the sign of a zero, or (marked `rounding`) move the result by
about one rounding. Three are right for finite numbers only and are kept because models are full of
structural zeros: x * 0 is 0, x - x is 0, and a boolean times x is x or 0. A NaN or infinity that
such a product would have spread is lost on that path; it stays in the value itself, where any test
of the value sees it. No rule negates a comparison of floats, which NaN would get wrong.
"""

from typing import Any

import numpy as np

from mjxwalk.engines.lanes.ir import boolean_rules
from mjxwalk.engines.lanes.ir.bounds import bounds, type_bounds
from mjxwalk.engines.lanes.ir.builder import GraphBuilder, Rule, Values
from mjxwalk.engines.lanes.ir.graph import Graph
from mjxwalk.engines.lanes.ir.semantics import evaluate, is_float


def _add(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x, y = args
    if values[1] is not None and values[1] == 0:
        return x
    if b.op(y) == "neg":
        return b.same("sub", x, b.args(y)[0])
    if b.op(x) == "neg":
        return b.same("sub", y, b.args(x)[0])
    if not is_float(dtype) and values[1] is not None and b.op(x) == "add":
        return _regroup(b, "add", x, y)
    if b.op(y) == "mul" and b.op(x) == "mul":
        return _factor(b, "add", x, y)
    return None


def _sub(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x, y = args
    if values[1] is not None and (values[1] == 0 or not is_float(dtype)):
        return b.same("add", x, b.same("neg", y))
    if values[0] is not None and values[0] == 0:
        return b.same("neg", y)
    if x == y:
        return b.constant(0, dtype)
    if b.op(y) == "neg":
        return b.same("add", x, b.args(y)[0])
    if b.op(x) == "neg":
        return b.same("neg", b.same("add", b.args(x)[0], y))
    return None


def _factor(b: GraphBuilder, op: str, x: int, y: int) -> int | None:
    """Turns x1 * c + y1 * -c into (x1 - y1) * c, which leaves the product for others to share."""
    (x1, cx), (y1, cy) = b.args(x), b.args(y)
    vx, vy = b.graph.value(cx), b.graph.value(cy)
    if op == "add" and vx is not None and vy is not None and vx == -vy and is_float(b.dtype(x)):
        return b.same("mul", b.same("sub", x1, y1), cx)
    return None


def _mul(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x, y = args
    value = values[1]
    if value is not None:
        if value == 0:
            return b.constant(0, dtype)
        if value == 1:
            return x
        if value == -1:
            return b.same("neg", x)
        if b.op(x) == "neg":
            return b.same("mul", b.args(x)[0], b.same("neg", y))
        if b.op(x) == "mul":  # rounding
            return _regroup(b, "mul", x, y)
        if b.is_flag(x):
            return b.select(b.args(x)[0], y, b.constant(0, dtype))
        return None
    for one, other in ((x, y), (y, x)):
        if b.op(one) == "neg":
            return b.same("neg", b.same("mul", b.args(one)[0], other))
        if b.is_flag(one):
            return b.select(b.args(one)[0], other, b.constant(0, dtype))
    return None


def _regroup(b: GraphBuilder, op: str, x: int, y: int) -> int | None:
    """Turns (x0 op c) op d into x0 op (c op d)."""
    inner, constant = b.args(x)
    if b.graph.value(constant) is None:
        return None
    return b.same(op, inner, b.same(op, constant, y))


def _div(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x, y = args
    if values[1] is not None:
        if values[1] == 1:
            return x
        if is_float(dtype) and _is_normal(values[1]) and _is_normal(1 / values[1]):  # rounding
            return b.same("mul", x, b.graph.constant(evaluate("recip", dtype, values[1])[()]))
        return None
    if is_float(dtype):
        if b.op(y) == "sqrt":  # rounding
            return b.same("mul", x, b.same("rsqrt", b.args(y)[0]))
        if b.op(y) == "neg":
            return b.same("neg", b.same("div", x, b.args(y)[0]))
        if values[0] is not None and values[0] == 1:
            return b.same("recip", y)
    return None


def _is_normal(value: Any) -> bool:
    return bool(np.isfinite(value)) and abs(float(value)) >= float(np.finfo(value.dtype).tiny)


def _neg(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x = args[0]
    if b.op(x) == "neg":
        return b.args(x)[0]
    if b.op(x) == "sub":
        return b.same("sub", *reversed(b.args(x)))
    if b.op(x) == "mul" and b.graph.value(b.args(x)[1]) is not None:
        return b.same("mul", b.args(x)[0], b.same("neg", b.args(x)[1]))
    return None


def _abs(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x = args[0]
    if b.op(x) == "abs" or dtype.startswith("uint"):
        return x
    return b.same("abs", b.args(x)[0]) if b.op(x) == "neg" else None


def _recip(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x = args[0]
    if b.op(x) == "sqrt":
        return b.same("rsqrt", b.args(x)[0])
    return None


def _extreme(op: str) -> Rule:
    def rule(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
        x, y = args
        if x == y:
            return x
        if values[1] is None or np.isnan(values[1]):
            return None
        if b.op(x) == op and b.graph.value(b.args(x)[1]) is not None:
            return _regroup(b, op, x, y)
        low, high = bounds(b.graph, x)
        limit = float(values[1])
        if (op == "max" and limit <= low) or (op == "min" and high <= limit):
            return x
        return None

    return rule


def _convert(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x = args[0]
    if b.dtype(x) == dtype:
        return x
    if dtype == "bool":
        return b.compare("ne", x, b.constant(0, b.dtype(x)))
    if b.is_flag(x):
        return b.convert(b.args(x)[0], dtype)
    source = b.dtype(x)
    if is_float(source) and not is_float(dtype):
        (low, high), (least, most) = bounds(b.graph, x), type_bounds(dtype)
        if least <= low and high < most:  # needs no clamp; `within` says so to the code generator
            return b.graph.add("convert", dtype, args, "within")
    return None


def _pow(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    """Turns small whole powers into products (rounding), as XLA does."""
    x, exponent = args[0], values[1]
    if exponent is None or exponent not in (0, 1, 2, 3, 4):
        return None
    power = b.constant(1, dtype)
    for bit in f"{int(exponent):b}":
        power = b.same("mul", power, power)
        power = b.same("mul", power, x) if bit == "1" else power
    return power


def _nothing(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    return None


def _rint(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    return args[0] if b.op(args[0]) in ("floor", "ceil", "rint") else None


RULES: dict[str, Rule] = {
    **dict.fromkeys(
        "rem sqrt rsqrt fma shl shr sar bitcast sin cos tan asin acos atan atan2 sinh cosh tanh "
        "asinh acosh atanh exp exp2 expm1 log log1p logistic cbrt erf erfc erf_inv".split(),
        _nothing,
    ),
    **boolean_rules.RULES,
    **{op: _extreme(op) for op in ("max", "min")},
    **dict.fromkeys(("floor", "ceil", "rint"), _rint),
    "add": _add,
    "sub": _sub,
    "mul": _mul,
    "div": _div,
    "recip": _recip,
    "neg": _neg,
    "abs": _abs,
    "pow": _pow,
    "convert": _convert,
}


def simplifying(graph: Graph) -> GraphBuilder:
    """Returns a builder with all rules."""
    return GraphBuilder(graph, RULES)
