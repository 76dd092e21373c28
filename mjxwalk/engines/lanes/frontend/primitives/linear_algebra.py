"""Matrix products, Cholesky factors and triangular systems, unrolled."""

from collections.abc import Callable

import numpy as np

from mjxwalk.engines.lanes.frontend import memory
from mjxwalk.engines.lanes.frontend.interpreter import (
    Handler,
    Interpreter,
    Nodes,
    Params,
    Refusal,
    Value,
)
from mjxwalk.engines.lanes.frontend.primitives.reductions import fold
from mjxwalk.engines.lanes.ir.graph import Array
from mjxwalk.engines.lanes.ir.semantics import is_float


def _dot_general(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    (contract_x, contract_y), (batch_x, batch_y) = p["dimension_numbers"]
    dtype = np.dtype(p["preferred_element_type"] or inputs[0].dtype).name
    kept = _in_memory(t, p, inputs, dtype)
    if kept is not None:
        return [kept]
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
    return [t.folded(np.array(sums, np.int64).reshape(batches + free_x + free_y), dtype)]


def _in_memory(t: Interpreter, p: Params, inputs: list[Value], dtype: str) -> Value | None:
    """Returns the product of a large matrix that is in memory, which a loop computes, else None."""
    contracted, batch = p["dimension_numbers"]
    if batch[0] or any(len(axes) != 1 for axes in contracted):
        return None
    if not is_float(dtype) or any(v.dtype != dtype or not isinstance(v, Nodes) for v in inputs):
        return None
    sides = [
        np.moveaxis(value.array, axis, -1)
        for value, (axis,) in zip(inputs, contracted, strict=True)
    ]
    terms = sides[0].shape[-1]
    left, right = (side.reshape(-1, terms) for side in sides)
    ids = memory.matrix_product(t.graph, left, right, dtype)
    if ids is None:
        return None
    return Nodes(ids.reshape(sides[0].shape[:-1] + sides[1].shape[:-1]), dtype)


def _product(t: Interpreter, row: list[int], column: list[int], dtype: str) -> int:
    make = t.build.make
    products = [make("mul", dtype, pair) for pair in zip(row, column, strict=True)]
    return fold(t, "add", products, dtype)


def _each_matrix(run: Callable[[Interpreter, Array, Params, str], Array]) -> Handler:
    def handler(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
        dtype = inputs[0].dtype
        a = t.nodes(inputs[0])
        done = [run(t, m, p, dtype) for m in a.reshape(-1, *a.shape[-2:])]
        return [t.folded(np.array(done, np.int64).reshape(a.shape), dtype)]

    return handler


def _cholesky(t: Interpreter, a: Array, p: Params, dtype: str) -> Array:
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


def _triangular_solve(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
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


def _substitute(t: Interpreter, a: Array, b: Array, lower: bool, unit: bool) -> Array:
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


HANDLERS: dict[str, Handler] = {
    "dot_general": _dot_general,
    "cholesky": _each_matrix(_cholesky),
    "triangular_solve": _triangular_solve,
}
