"""Simplification while the graph grows: folded constants, and identities of arithmetic.

The rules are exact, or exact but for the sign of a zero, or (marked `rounding`) move the result by
about one rounding. Three are right for finite numbers only and are kept because models are full of
structural zeros: x * 0 is 0, x - x is 0, and a boolean times x is x or 0. A NaN or infinity that
such a product would have spread is lost on that path; it stays in the value itself, where any test
of the value sees it. No rule negates a comparison of floats, which NaN would get wrong.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from mjxwalk.engines.lanes.bounds import Range, bounds, type_bounds
from mjxwalk.engines.lanes.graph import OUTSIDE, Graph
from mjxwalk.engines.lanes.scalars import COMMUTATIVE, COMPARISONS, evaluate, is_float


class Builder:
    """Adds nodes to a graph, simplified."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph

    def make(self, op: str, dtype: str, args: tuple[int, ...], data: Any = None) -> int:
        """Returns a node equal to the operation on args, simplified as far as the rules go."""
        rule = RULES.get(op)
        if rule is None:
            return self.graph.add(op, dtype, args, data)
        values = [self.graph.value(arg) for arg in args]
        if all(value is not None for value in values):
            return self.graph.constant(evaluate(op, dtype, *values)[()])  # type: ignore[arg-type]
        if op in COMMUTATIVE and values[0] is not None:  # constants stand second
            args, values = (args[1], args[0]), [values[1], values[0]]
        found = rule(self, dtype, args, values)
        if found is not None:
            return found
        if op in COMMUTATIVE and values[1] is None and args[0] > args[1]:
            args = (args[1], args[0])
        return self.graph.add(op, dtype, args, data)

    def constant(self, value: float | int, dtype: str) -> int:
        """Returns the node of a number in a type."""
        return self.graph.constant(np.asarray(value).astype(dtype)[()])

    def same(self, op: str, *args: int) -> int:
        """Returns an operation whose result has the type of its last argument."""
        return self.make(op, self.dtype(args[-1]), args)

    def compare(self, op: str, x: int, y: int) -> int:
        """Returns a comparison, a boolean."""
        return self.make(op, "bool", (x, y))

    def select(self, predicate: int, on_true: int, on_false: int) -> int:
        """Returns one of two nodes by a boolean."""
        return self.same("select", predicate, on_true, on_false)

    def convert(self, x: int, dtype: str) -> int:
        """Returns x in another type."""
        return self.make("convert", dtype, (x,))

    def dtype(self, node: int) -> str:
        """Returns the type of a node."""
        return self.graph.nodes[node].dtype

    def op(self, node: int) -> str:
        """Returns the operation of a node."""
        return self.graph.nodes[node].op

    def args(self, node: int) -> tuple[int, ...]:
        """Returns the arguments of a node."""
        return self.graph.nodes[node].args

    def substitute(
        self, live: Iterable[int], source: Graph, known: Mapping[int, int], parent: int = OUTSIDE
    ) -> dict[int, int]:
        """Rebuilds live nodes of `source`, in order; `known` says what some of them become.

        Rebuilding in order lets every simplification see its simplified arguments. Loops that the
        nodes belong to are rebuilt too, those that stood outside all others inside `parent`.
        Returns the new id of every live node.
        """
        mapping = dict(known)
        loops: dict[int, int] = {}
        for node_id in live:
            if node_id in mapping:
                continue
            value = source.value(node_id)
            if value is not None:
                mapping[node_id] = self.graph.constant(value)
                continue
            op, dtype, args, data = source.nodes[node_id]
            if op in ("carry", "result"):
                data = (self._loop(source, data[0], loops, parent), data[1])
            mapping[node_id] = self.make(op, dtype, tuple(mapping[arg] for arg in args), data)
        for old, new in loops.items():
            self.graph.loops[new].fill(source.loops[old], mapping)
        return mapping

    def _loop(self, source: Graph, number: int, loops: dict[int, int], parent: int) -> int:
        """Returns the new number of a loop of `source`, made on first use."""
        if number not in loops:
            old = source.loops[number].parent
            outer = self._loop(source, old, loops, parent) if old in loops else parent
            loops[number] = self.graph.new_loop(outer)
        return loops[number]


Values = list[Any]
Rule = Callable[[Builder, str, tuple[int, ...], Values], int | None]


def _add(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
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


def _sub(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
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


def _factor(b: Builder, op: str, x: int, y: int) -> int | None:
    """Turns x1 * c + y1 * -c into (x1 - y1) * c, which leaves the product for others to share."""
    (x1, cx), (y1, cy) = b.args(x), b.args(y)
    vx, vy = b.graph.value(cx), b.graph.value(cy)
    if op == "add" and vx is not None and vy is not None and vx == -vy and is_float(b.dtype(x)):
        return b.same("mul", b.same("sub", x1, y1), cx)
    return None


def _mul(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
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
        if _is_flag(b, x):
            return b.select(b.args(x)[0], y, b.constant(0, dtype))
        return None
    for one, other in ((x, y), (y, x)):
        if b.op(one) == "neg":
            return b.same("neg", b.same("mul", b.args(one)[0], other))
        if _is_flag(b, one):
            return b.select(b.args(one)[0], other, b.constant(0, dtype))
    return None


def _regroup(b: Builder, op: str, x: int, y: int) -> int | None:
    """Turns (x0 op c) op d into x0 op (c op d)."""
    inner, constant = b.args(x)
    if b.graph.value(constant) is None:
        return None
    return b.same(op, inner, b.same(op, constant, y))


def _is_flag(b: Builder, x: int) -> bool:
    return b.op(x) == "convert" and b.dtype(b.args(x)[0]) == "bool"


def _div(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
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


def _neg(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x = args[0]
    if b.op(x) == "neg":
        return b.args(x)[0]
    if b.op(x) == "sub":
        return b.same("sub", *reversed(b.args(x)))
    if b.op(x) == "mul" and b.graph.value(b.args(x)[1]) is not None:
        return b.same("mul", b.args(x)[0], b.same("neg", b.args(x)[1]))
    return None


def _abs(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x = args[0]
    if b.op(x) == "abs" or dtype.startswith("uint"):
        return x
    return b.same("abs", b.args(x)[0]) if b.op(x) == "neg" else None


def _recip(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x = args[0]
    if b.op(x) == "sqrt":
        return b.same("rsqrt", b.args(x)[0])
    return None


def _extreme(op: str) -> Rule:
    def rule(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
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


def _bitwise(op: str) -> Rule:
    def rule(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
        x, y = args
        if x == y:
            return b.constant(0, dtype) if op == "xor" else x
        if values[1] is None:
            return None
        empty, full = values[1] == 0, values[1] == np.invert(np.zeros((), dtype))
        if empty:
            return y if op == "and" else x
        if full:
            return x if op == "and" else y if op == "or" else b.same("not", x)
        return None

    return rule


def _not(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x = args[0]
    if b.op(x) == "not":
        return b.args(x)[0]
    if b.op(x) in ("eq", "ne"):  # the one negation that NaN does not mind
        return b.compare("ne" if b.op(x) == "eq" else "eq", *b.args(x))
    if b.op(x) in ("lt", "le") and not is_float(b.dtype(b.args(x)[0])):
        return b.compare("le" if b.op(x) == "lt" else "lt", *reversed(b.args(x)))
    return None


def _select(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    predicate, x, y = args
    if values[0] is not None:
        return x if values[0] else y
    if x == y:
        return x
    if b.op(predicate) == "not":
        return b.select(b.args(predicate)[0], y, x)
    if b.op(x) == "select" and b.args(x)[0] == predicate:
        return b.select(predicate, b.args(x)[1], y)
    if b.op(y) == "select" and b.args(y)[0] == predicate:
        return b.select(predicate, x, b.args(y)[2])
    if dtype == "bool":
        if values[1] is not None:
            return (
                b.same("or", predicate, y)
                if values[1]
                else b.same("and", b.same("not", predicate), y)
            )
        if values[2] is not None:
            return (
                b.same("or", b.same("not", predicate), x)
                if values[2]
                else b.same("and", predicate, x)
            )
    return None


def _convert(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x = args[0]
    if b.dtype(x) == dtype:
        return x
    if dtype == "bool":
        return b.compare("ne", x, b.constant(0, b.dtype(x)))
    if _is_flag(b, x):
        return b.convert(b.args(x)[0], dtype)
    source = b.dtype(x)
    if is_float(source) and not is_float(dtype):
        (low, high), (least, most) = bounds(b.graph, x), type_bounds(dtype)
        if least <= low and high < most:  # needs no clamp; `within` says so to the code generator
            return b.graph.add("convert", dtype, args, "within")
    return None


def _comparison(op: str) -> Rule:
    def rule(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
        x, y = args
        if not is_float(b.dtype(x)):
            if x == y:
                return b.constant(op in ("le", "eq"), "bool")
            certain = _certain(op, bounds(b.graph, x), bounds(b.graph, y))
            if certain is not None:
                return b.constant(certain, "bool")
        for place, value in ((0, values[1]), (1, values[0])):
            choice = None if value is None else _two_constants(b, args[place])
            if choice is None:
                continue
            predicate, *outcomes = choice
            sides = [(c, value) if place == 0 else (value, c) for c in outcomes]
            held, failed = (bool(evaluate(op, "bool", *side)) for side in sides)
            if held == failed:
                return b.constant(held, "bool")
            return predicate if held else b.same("not", predicate)
        if b.dtype(x) == "bool" and values[1] is not None and op in ("eq", "ne"):
            return x if bool(values[1]) == (op == "eq") else b.same("not", x)
        return None

    return rule


def _certain(op: str, x: Range, y: Range) -> bool | None:
    """Returns what a comparison of integers comes to, if their ranges decide it."""
    if x[1] < y[0]:
        return op in ("lt", "le", "ne")
    if x[0] > y[1]:
        return op == "ne"
    if op == "lt" and x[0] >= y[1]:
        return False
    if op == "le" and x[1] <= y[0]:
        return True
    return None


def _two_constants(b: Builder, x: int) -> tuple[int, Any, Any] | None:
    """Returns (predicate, value if true, value if false) of a choice between two constants."""
    if _is_flag(b, x):
        one = np.ones((), b.dtype(x))[()]
        return b.args(x)[0], one, one - one
    if b.op(x) == "select":
        predicate, on_true, on_false = b.args(x)
        held, failed = b.graph.value(on_true), b.graph.value(on_false)
        if held is not None and failed is not None:
            return predicate, held, failed
    return None


def _nothing(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    return None


def _rint(b: Builder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    return args[0] if b.op(args[0]) in ("floor", "ceil", "rint") else None


RULES: dict[str, Rule] = {
    **dict.fromkeys(
        "rem sqrt rsqrt fma shl shr sar bitcast sin cos tan asin acos atan atan2 sinh cosh tanh asinh "
        "acosh atanh exp exp2 expm1 log log1p logistic pow cbrt erf".split(),
        _nothing,
    ),
    **{op: _comparison(op) for op in COMPARISONS},
    **{op: _bitwise(op) for op in ("and", "or", "xor")},
    **{op: _extreme(op) for op in ("max", "min")},
    **dict.fromkeys(("floor", "ceil", "rint"), _rint),
    "add": _add,
    "sub": _sub,
    "mul": _mul,
    "div": _div,
    "recip": _recip,
    "neg": _neg,
    "abs": _abs,
    "not": _not,
    "select": _select,
    "convert": _convert,
}
