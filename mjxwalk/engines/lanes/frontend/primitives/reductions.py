"""Reductions and cumulative operations, unrolled."""

from typing import Any

import numpy as np

from mjxwalk.engines.lanes.frontend.interpreter import Handler, Interpreter, Params, Value
from mjxwalk.engines.lanes.ir.graph import Array
from mjxwalk.engines.lanes.ir.semantics import is_float

REDUCTIONS = {"reduce_sum": "add", "reduce_prod": "mul", "reduce_max": "max", "reduce_min": "min",
              "reduce_and": "and", "reduce_or": "or", "reduce_xor": "xor"}  # fmt: skip
CUMULATIVE = {"cumsum": "add", "cumprod": "mul", "cummax": "max", "cummin": "min"}


def _start(op: str, dtype: str) -> Any:
    """Returns the number that leaves any other unchanged."""
    if op in ("max", "min"):
        if dtype == "bool":
            return op == "min"
        if is_float(dtype):
            return -np.inf if op == "max" else np.inf
        limits = np.iinfo(dtype)
        return limits.min if op == "max" else limits.max
    return {"add": 0, "mul": 1, "and": -1, "or": 0, "xor": 0}[op]


def fold(t: Interpreter, op: str, ids: list[int], dtype: str) -> int:
    """Returns the ids combined from first to last."""
    if not ids:
        return t.build.constant(_start(op, dtype), dtype)
    total = ids[0]
    for number in ids[1:]:
        total = t.build.make(op, dtype, (total, number))
    return total


def _rows(x: Array, axes: tuple[int, ...]) -> tuple[Array, tuple[int, ...]]:
    """Returns the array as rows to be reduced, and the shape of the rows' results."""
    kept = [axis for axis in range(x.ndim) if axis not in axes]
    shape = tuple(x.shape[axis] for axis in kept)
    summed = [x.shape[axis] for axis in axes]
    flat = x.transpose((*kept, *axes)).reshape([int(np.prod(n)) for n in (shape, summed)])
    return flat, shape


def _reduction(op: str) -> Handler:
    def handler(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
        dtype = inputs[0].dtype
        rows, shape = _rows(t.nodes(inputs[0]), tuple(map(int, p["axes"])))
        ids = np.array([fold(t, op, row, dtype) for row in rows.tolist()], np.int64)
        return [t.folded(ids.reshape(shape), dtype)]

    return handler


def _cumulative(op: str) -> Handler:
    def handler(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
        dtype, axis = inputs[0].dtype, p["axis"]
        ids = np.moveaxis(t.nodes(inputs[0]), axis, 0)[:: -1 if p["reverse"] else 1].copy()
        for row in range(1, len(ids)):
            for place in np.ndindex(ids.shape[1:]):
                pair = (int(ids[row - 1][place]), int(ids[row][place]))
                ids[(row, *place)] = t.build.make(op, dtype, pair)
        return [t.folded(np.moveaxis(ids[:: -1 if p["reverse"] else 1], 0, axis), dtype)]

    return handler


def _arg_extreme(op: str) -> Handler:
    def handler(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
        dtype, index = inputs[0].dtype, np.dtype(p["index_dtype"]).name
        rows, shape = _rows(t.nodes(inputs[0]), tuple(map(int, p["axes"])))
        build, found = t.build, []
        for row in rows.tolist():
            best, place = row[0], build.constant(0, index)
            for number, candidate in enumerate(row[1:], 1):
                pair = (best, candidate) if op == "argmax" else (candidate, best)
                better = build.compare("lt", *pair)
                if is_float(dtype):  # the first NaN wins, as in XLA
                    unordered = build.compare("ne", candidate, candidate)
                    settled = build.compare("eq", best, best)
                    better = build.same("or", better, build.same("and", unordered, settled))
                best = build.select(better, candidate, best)
                place = build.select(better, build.constant(number, index), place)
            found.append(place)
        return [t.folded(np.array(found, np.int64).reshape(shape), index)]

    return handler


HANDLERS: dict[str, Handler] = {
    **{name: _reduction(op) for name, op in REDUCTIONS.items()},
    **{name: _cumulative(op) for name, op in CUMULATIVE.items()},
    "argmax": _arg_extreme("argmax"),
    "argmin": _arg_extreme("argmin"),
}
