"""Sorting, as a network of comparisons."""

import numpy as np

from mjxwalk.engines.lanes.frontend.interpreter import Handler, Interpreter, Params, Value
from mjxwalk.engines.lanes.ir.semantics import is_float


def _sort(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
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
    return [t.folded(ids, value.dtype) for ids, value in zip(moved, inputs, strict=True)]


def _before(t: Interpreter, pairs: list[tuple[int, int]]) -> int:
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


HANDLERS: dict[str, Handler] = {"sort": _sort}
