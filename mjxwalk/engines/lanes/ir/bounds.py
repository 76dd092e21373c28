"""What range a node's value lies in, where that is plain: enough to drop needless clamps.

Bounds hold unless the value is NaN; integers have no NaN, and theirs hold always.
"""

import math
from collections.abc import Sequence

import numpy as np

from mjxwalk.engines.lanes.ir.graph import Graph, Node
from mjxwalk.engines.lanes.ir.semantics import is_float

Range = tuple[float, float]
ANYTHING: Range = (-math.inf, math.inf)
DEPTH = 12  # nodes to look back


def bounds(graph: Graph, node_id: int, depth: int = DEPTH) -> Range:
    """Returns the least and the greatest value of a number, or infinities."""
    found = graph.ranges.get((node_id, depth))
    if found is None:
        found = graph.ranges[node_id, depth] = _bounds(graph, node_id, depth)
    return found


def _bounds(graph: Graph, node_id: int, depth: int) -> Range:
    value = graph.value(node_id)
    node = graph.nodes[node_id]
    if value is not None:
        number = float(value)
        return ANYTHING if math.isnan(number) else (number, number)
    if depth == 0 or node.op not in _BOUNDED:
        return type_bounds(node.dtype)
    ranges = [
        bounds(graph, arg, depth - 1)
        for arg in node.args
        if node.op != "select" or arg != node.args[0]
    ]
    if node.op == "convert":
        return _converted(graph.dtype(node.args[0]), node.dtype, *ranges[0])
    low, high = _combined(node.op, ranges)
    if is_float(node.dtype):
        return _rounded(graph, node, ranges, low, high)
    least, most = type_bounds(node.dtype)
    return (low, high) if least <= low and high <= most else (least, most)  # integers wrap around


def type_bounds(dtype: str) -> Range:
    """Returns the range of a type."""
    if is_float(dtype):
        return ANYTHING
    if dtype == "bool":
        return 0.0, 1.0
    limits = np.iinfo(dtype)
    return float(limits.min), float(limits.max)


def _converted(source: str, dtype: str, low: float, high: float) -> Range:
    """Returns the range after a conversion: integers wrap, floats clamp and NaN becomes 0."""
    if is_float(dtype):
        return _as_float(dtype, low), _as_float(dtype, high)
    least, most = type_bounds(dtype)
    if not is_float(source):
        return (low, high) if least <= low and high <= most else (least, most)
    low, high = min(max(low, least), most), max(min(high, most), least)
    whole = (math.trunc(low), math.trunc(high))
    return float(min(*whole, 0)), float(max(*whole, 0))


def _rounded(graph: Graph, node: Node, ranges: Sequence[Range], low: float, high: float) -> Range:
    """Returns the range of a float after rounding: a sum may have taken in an unrounded product."""
    low, high = _as_float(node.dtype, low), _as_float(node.dtype, high)
    if node.op in ("add", "sub") and any(graph.nodes[arg].op == "mul" for arg in node.args):
        finite = [abs(end) for ends in ranges for end in ends if math.isfinite(end)]
        slack = max(finite, default=0.0) * float(np.finfo(node.dtype).eps)
        return low - slack, high + slack
    return low, high


def _as_float(dtype: str, number: float) -> float:
    with np.errstate(over="ignore"):
        return float(np.asarray(number, dtype))


_BOUNDED = frozenset("min max floor ceil rint convert select and add sub mul neg abs".split())


def _combined(op: str, ranges: list[Range]) -> Range:
    (low, high), (low2, high2) = ranges[0], ranges[-1]
    if op == "min":
        return min(low, low2), min(high, high2)
    if op == "max":
        return max(low, low2), max(high, high2)
    if op == "select":
        return min(low, low2), max(high, high2)
    if op == "add":
        return _ordered(low + low2, high + high2)
    if op == "sub":
        return _ordered(low - high2, high - low2)
    if op == "neg":
        return -high, -low
    if op == "abs":
        return 0.0 if low <= 0 <= high else min(abs(low), abs(high)), max(abs(low), abs(high))
    if op == "mul":
        corners = [x * y for x in (low, high) for y in (low2, high2)]
        return ANYTHING if any(map(math.isnan, corners)) else (min(corners), max(corners))
    if op == "and":  # of integers that are not negative
        return (0.0, min(high, high2)) if low >= 0 and low2 >= 0 else (
            (0.0, max(high, high2)) if low >= 0 or low2 >= 0 else ANYTHING
        )  # fmt: skip
    rounding = {"floor": math.floor, "ceil": math.ceil, "rint": round}[op]
    return (
        float(rounding(low)) if math.isfinite(low) else low,
        float(rounding(high)) if math.isfinite(high) else high,
    )


def _ordered(low: float, high: float) -> Range:
    return ANYTHING if math.isnan(low) or math.isnan(high) else (low, high)
