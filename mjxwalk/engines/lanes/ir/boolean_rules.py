"""Rules for booleans, bits, choices and comparisons."""

from typing import Any

import numpy as np

from mjxwalk.engines.lanes.ir.bounds import Range, bounds
from mjxwalk.engines.lanes.ir.builder import GraphBuilder, Rule, Values
from mjxwalk.engines.lanes.ir.semantics import COMPARISONS, evaluate, is_float


def _bitwise(op: str) -> Rule:
    def rule(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
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


def _not(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
    x = args[0]
    if b.op(x) == "not":
        return b.args(x)[0]
    if b.op(x) in ("eq", "ne"):  # the one negation that NaN does not mind
        return b.compare("ne" if b.op(x) == "eq" else "eq", *b.args(x))
    if b.op(x) in ("lt", "le") and not is_float(b.dtype(b.args(x)[0])):
        return b.compare("le" if b.op(x) == "lt" else "lt", *reversed(b.args(x)))
    return None


def _select(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
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


def _comparison(op: str) -> Rule:
    def rule(b: GraphBuilder, dtype: str, args: tuple[int, ...], values: Values) -> int | None:
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


def _two_constants(b: GraphBuilder, x: int) -> tuple[int, Any, Any] | None:
    """Returns (predicate, value if true, value if false) of a choice between two constants."""
    if b.is_flag(x):
        one = np.ones((), b.dtype(x))[()]
        return b.args(x)[0], one, one - one
    if b.op(x) == "select":
        predicate, on_true, on_false = b.args(x)
        held, failed = b.graph.value(on_true), b.graph.value(on_false)
        if held is not None and failed is not None:
            return predicate, held, failed
    return None


RULES: dict[str, Rule] = {
    **{op: _comparison(op) for op in COMPARISONS},
    **{op: _bitwise(op) for op in ("and", "or", "xor")},
    "not": _not,
    "select": _select,
}
