"""Reductions, products and factorisations, unrolled."""

from collections.abc import Callable
from typing import Any

import numpy as np

from mjxwalk.engines.lanes.graph import Array
from mjxwalk.engines.lanes.scalars import is_float
from mjxwalk.engines.lanes.tracing import Equation, Handler, Nodes, Refusal, Tracer, Value

Params = dict[str, Any]
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


def fold(t: Tracer, op: str, ids: list[int], dtype: str) -> int:
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
    def handler(t: Tracer, p: Params, inputs: list[Value], equation: Equation) -> list[Value]:
        dtype = inputs[0].dtype
        rows, shape = _rows(t.nodes(inputs[0]), tuple(map(int, p["axes"])))
        ids = np.array([fold(t, op, row, dtype) for row in rows.tolist()], np.int64)
        return [t.settled(ids.reshape(shape), dtype)]

    return handler


def _cumulative(op: str) -> Handler:
    def handler(t: Tracer, p: Params, inputs: list[Value], equation: Equation) -> list[Value]:
        dtype, axis = inputs[0].dtype, p["axis"]
        ids = np.moveaxis(t.nodes(inputs[0]), axis, 0)[:: -1 if p["reverse"] else 1].copy()
        for row in range(1, len(ids)):
            for place in np.ndindex(ids.shape[1:]):
                pair = (int(ids[row - 1][place]), int(ids[row][place]))
                ids[(row, *place)] = t.build.make(op, dtype, pair)
        return [t.settled(np.moveaxis(ids[:: -1 if p["reverse"] else 1], 0, axis), dtype)]

    return handler


def _arg_extreme(op: str) -> Handler:
    def handler(t: Tracer, p: Params, inputs: list[Value], equation: Equation) -> list[Value]:
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
        return [t.settled(np.array(found, np.int64).reshape(shape), index)]

    return handler


def _dot_general(t: Tracer, p: Params, inputs: list[Value], equation: Equation) -> list[Value]:
    (contract_x, contract_y), (batch_x, batch_y) = p["dimension_numbers"]
    dtype = np.dtype(p["preferred_element_type"] or inputs[0].dtype).name
    sides: list[tuple[Array, tuple[int, ...]]] = []
    for value, contracted, batch in (
        (inputs[0], contract_x, batch_x),
        (inputs[1], contract_y, batch_y),
    ):
        ids = t.nodes(t.apply("convert", dtype, value))
        free = [axis for axis in range(ids.ndim) if axis not in (*contracted, *batch)]
        batches = tuple(ids.shape[axis] for axis in batch)
        frees = tuple(ids.shape[axis] for axis in free)
        summed = tuple(ids.shape[axis] for axis in contracted)
        ids = ids.transpose((*batch, *free, *contracted))
        sides.append((ids.reshape([int(np.prod(n)) for n in (batches, frees, summed)]), frees))
    (x, free_x), (y, free_y) = sides
    batches = tuple(inputs[0].array.shape[axis] for axis in batch_x)
    sums = [
        _product(t, row, column, dtype)
        for rows, columns in zip(x.tolist(), y.tolist(), strict=True)
        for row in rows
        for column in columns
    ]
    return [t.settled(np.array(sums, np.int64).reshape(batches + free_x + free_y), dtype)]


def _product(t: Tracer, row: list[int], column: list[int], dtype: str) -> int:
    make = t.build.make
    products = [make("mul", dtype, pair) for pair in zip(row, column, strict=True)]
    return fold(t, "add", products, dtype)


def _each_matrix(
    run: Callable[[Tracer, Array, Params, str], Array],
) -> Handler:
    def handler(t: Tracer, p: Params, inputs: list[Value], equation: Equation) -> list[Value]:
        dtype = inputs[0].dtype
        a = t.nodes(inputs[0])
        done = [run(t, m, p, dtype) for m in a.reshape(-1, *a.shape[-2:])]
        return [t.settled(np.array(done, np.int64).reshape(a.shape), dtype)]

    return handler


def _cholesky(t: Tracer, a: Array, p: Params, dtype: str) -> Array:
    """Lower factor, column by column; a matrix that is not positive definite gives NaN."""
    build, size = t.build, len(a)
    factor = np.full_like(a, build.constant(0, dtype))
    for j in range(size):
        column = a[j:, j].tolist()
        for k in range(j):
            for i, total in enumerate(column, j):
                product = build.same("mul", int(factor[i, k]), int(factor[j, k]))
                column[i - j] = build.same("sub", total, product)
        inverse = build.same("rsqrt", column[0])
        factor[j, j] = build.same("sqrt", column[0])
        factor[j + 1 :, j] = [build.same("mul", total, inverse) for total in column[1:]]
    return factor


def _triangular_solve(t: Tracer, p: Params, inputs: list[Value], equation: Equation) -> list[Value]:
    dtype = inputs[0].dtype
    a, b = t.nodes(inputs[0]), t.nodes(inputs[1])
    if p["conjugate_a"] and not is_float(dtype):
        raise Refusal("is of complex numbers")
    lower = p["lower"]
    if p["transpose_a"]:
        a, lower = a.swapaxes(-1, -2), not lower
    if not p["left_side"]:  # x a = b is transpose(a) transpose(x) = transpose(b)
        a, b, lower = a.swapaxes(-1, -2), b.swapaxes(-1, -2), not lower
    shape = b.shape
    pairs = zip(a.reshape(-1, *a.shape[-2:]), b.reshape(-1, *shape[-2:]), strict=True)
    solved = np.array([_substitute(t, m, y, lower, p["unit_diagonal"]) for m, y in pairs])
    solved = solved.reshape(shape)
    return [Nodes(solved if p["left_side"] else solved.swapaxes(-1, -2), dtype)]


def _substitute(t: Tracer, a: Array, b: Array, lower: bool, unit: bool) -> Array:
    """Solves a x = b for every column of b, row by row."""
    build, size = t.build, len(a)
    x = b.copy()
    order = range(size) if lower else range(size - 1, -1, -1)
    for column in range(b.shape[1]):
        for i in order:
            total = int(b[i, column])
            for k in range(i) if lower else range(i + 1, size):
                product = build.same("mul", int(a[i, k]), int(x[k, column]))
                total = build.same("sub", total, product)
            if not unit:
                inverse = build.same("div", build.constant(1, build.dtype(total)), int(a[i, i]))
                total = build.same("mul", total, inverse)
            x[i, column] = total
    return x


def _sort(t: Tracer, p: Params, inputs: list[Value], equation: Equation) -> list[Value]:
    """Sorts by insertion, stable; NaN last, and it alone decides nothing between equals."""
    axis, keys = p["dimension"], p["num_keys"]
    arrays = [np.moveaxis(t.nodes(value), axis, -1).copy() for value in inputs]
    size = arrays[0].shape[-1]
    for row in np.ndindex(arrays[0].shape[:-1]):
        lines = [array[row] for array in arrays]
        for end in range(size - 1, 0, -1):
            for i in range(end):
                swap = _before(t, [(int(x[i + 1]), int(x[i])) for x in lines[:keys]])
                for line in lines:
                    first, second = int(line[i]), int(line[i + 1])
                    line[i] = t.build.select(swap, second, first)
                    line[i + 1] = t.build.select(swap, first, second)
    moved = [np.moveaxis(array, -1, axis) for array in arrays]
    return [t.settled(ids, value.dtype) for ids, value in zip(moved, inputs, strict=True)]


def _before(t: Tracer, pairs: list[tuple[int, int]]) -> int:
    """Returns whether the first of each pair sorts strictly before the second."""
    build = t.build
    before = build.constant(False, "bool")
    for x, y in reversed(pairs):
        less = build.compare("lt", x, y)
        if is_float(build.dtype(x)):
            ordered, unordered = build.compare("eq", x, x), build.compare("ne", y, y)
            less = build.same("or", less, build.same("and", ordered, unordered))
        equal = build.compare("eq", x, y)
        before = build.same("or", less, build.same("and", equal, before))
    return before


HANDLERS: dict[str, Handler] = {
    **{name: _reduction(op) for name, op in REDUCTIONS.items()},
    **{name: _cumulative(op) for name, op in CUMULATIVE.items()},
    "argmax": _arg_extreme("argmax"),
    "argmin": _arg_extreme("argmin"),
    "dot_general": _dot_general,
    "cholesky": _each_matrix(_cholesky),
    "triangular_solve": _triangular_solve,
    "sort": _sort,
}
