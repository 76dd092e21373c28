"""Windows of an array, at places that may depend on the walker.

A window has a place in the operand, and steps within it that are the same for all windows. Where
the places are known, the rest is numpy. Where a walker computes them, a read becomes a clamped
load from the input's memory or from a table of constants, or a tree of selects over computed
numbers; a write becomes a select per number that it could reach.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from mjxwalk.engines.lanes.frontend.interpreter import (
    ARGUMENT,
    Interpreter,
    Known,
    Nodes,
    Refusal,
    Value,
)
from mjxwalk.engines.lanes.ir.graph import Array

MOST_SELECTS = 1 << 14  # for one write at a computed place: beyond, the code would be absurd
SMALL_TABLE = 4  # constants up to which selects are cheaper than a load from a table


def int32(number: int) -> Known:
    """Returns a known index."""
    return Known(np.asarray(number, np.int32))


@dataclasses.dataclass(frozen=True)
class Windows:
    """Where windows lie in the flat operand.

    Attributes:
      places: flat start of each window, [...], known or computed by the walker.
      inside: whether a window lies inside as asked; those outside are clamped.
      steps: flat distance of each of a window's numbers from its start, [...].
    """

    places: Value
    inside: Value
    steps: Array

    def clamped(self) -> "Windows":
        """Returns the windows where all count as inside, at the places that they have."""
        everywhere = Known(np.ones(self.inside.array.shape, np.bool_))
        return dataclasses.replace(self, inside=everywhere)


def place_windows(
    t: Interpreter, shape: Sequence[int], starts: Sequence[Value], sizes: Sequence[int]
) -> Windows:
    """Returns the windows of these sizes at `starts`, one value per axis, clamped into `shape`."""
    strides = [int(np.prod(shape[axis + 1 :])) for axis in range(len(shape))]
    places: Value = Known(np.zeros((), np.int32))
    inside: Value = Known(np.ones((), np.bool_))
    for start, size, length, stride in zip(starts, sizes, shape, strides, strict=True):
        start = _asint32(t, start)
        zero, last = int32(0), int32(length - size)
        clamped = t.apply("max", "int32", t.apply("min", "int32", start, last), zero)
        inside = t.apply("and", "bool", inside, t.apply("eq", "bool", start, clamped))
        step = t.apply("mul", "int32", clamped, int32(stride))
        places = t.apply("add", "int32", places, step)
    steps = np.zeros(tuple(sizes), np.int64)
    for axis, stride in enumerate(strides):
        along = [-1 if other == axis else 1 for other in range(len(shape))]
        steps = steps + np.arange(sizes[axis]).reshape(along) * stride
    return Windows(places, inside, steps)


def _asint32(t: Interpreter, start: Value) -> Value:
    """Returns an index as int32, an unsigned one that is too large as the largest."""
    if start.dtype.startswith("uint"):
        top = Known(np.asarray(np.iinfo(np.int32).max).astype(start.dtype))
        start = t.apply("min", start.dtype, start, top) if start.dtype > "uint16" else start
    return t.apply("convert", "int32", start)


def read_windows(t: Interpreter, operand: Value, windows: Windows) -> Value:
    """Returns the windows' numbers, [places..., steps...]."""
    window_axes = (1,) * windows.steps.ndim
    if isinstance(windows.places, Known):
        places = windows.places.array
        flat = places.reshape(places.shape + window_axes) + windows.steps
        return t.move(lambda x: x.ravel()[flat], operand)
    places = windows.places.array
    read = [
        _at(t, operand, place, step)
        for place in places.ravel().tolist()
        for step in windows.steps.ravel().tolist()
    ]
    return Nodes(
        np.array(read, np.int64).reshape(places.shape + windows.steps.shape), operand.dtype
    )


def _at(t: Interpreter, operand: Value, place: int, step: int) -> int:
    """Returns the node of the operand's number at a computed flat place, known to be inside."""
    make, graph = t.build.make, t.graph
    flat = operand.array.ravel()
    if isinstance(operand, Known) and flat.size > SMALL_TABLE:
        index = make("add", "int32", (place, graph.constant(np.int32(step))))
        return make("lookup", operand.dtype, (index,), graph.table(operand.array))
    if isinstance(operand, Nodes) and flat.size > 1 and flat.min() >= ARGUMENT:
        stride = int(flat[1] - flat[0])
        argument, first = divmod(int(flat[0]) - ARGUMENT, ARGUMENT)
        if (np.diff(flat) == stride).all() and stride > 0:
            index = make("mul", "int32", (place, graph.constant(np.int32(stride))))
            offset = graph.constant(np.int32(first + step * stride))
            index = make("add", "int32", (index, offset))
            return make("load", operand.dtype, (index,), argument)
    return _choose(t, t.nodes(operand).ravel().tolist()[step:], place)


def _choose(t: Interpreter, choices: list[int], place: int) -> int:
    """Returns choices[place] by a tree of selects, one level for each bit of the place."""
    build = t.build
    bit = 1
    while len(choices) > 1:
        masked = build.same("and", place, build.constant(bit, "int32"))
        odd = build.compare("ne", masked, build.constant(0, "int32"))
        pairs = zip(choices[::2], [*choices[1::2], choices[-1]], strict=False)
        choices = [build.select(odd, second, first) for first, second in pairs]
        bit <<= 1
    return choices[0]


def write_windows(
    t: Interpreter, operand: Value, windows: Windows, updates: Value, combine: str
) -> Value:
    """Returns the operand with updates [places..., steps...] put in, in order, where inside."""
    if updates.array.size == 0:
        return operand
    ids = t.nodes(operand).copy().ravel()
    new = t.nodes(updates).reshape(-1, windows.steps.size)
    inside = t.nodes(windows.inside).ravel().tolist()
    steps = windows.steps.ravel().tolist()
    build, dtype = t.build, operand.dtype
    known = isinstance(windows.places, Known)
    if not known and ids.size * new.size > MOST_SELECTS:
        raise Refusal(
            f"writes {new.size} of {ids.size} numbers at places that each walker computes"
        )
    places = windows.places.array.ravel().tolist()
    for place, valid, row in zip(places, inside, new.tolist(), strict=True):
        for step, update in zip(steps, row, strict=True):
            for spot in [place + step] if known else range(step, ids.size):
                here = valid
                if not known:
                    at = build.constant(spot - step, "int32")
                    here = build.same("and", valid, build.compare("eq", place, at))
                old = int(ids[spot])
                put = update if combine == "set" else build.make(combine, dtype, (old, update))
                ids[spot] = build.select(here, put, old)
    return Nodes(ids.reshape(operand.array.shape), dtype)


def read_row(t: Interpreter, operand: Value, place: Value) -> Value:
    """Returns operand[place] along the first axis, clamped."""
    shape = operand.array.shape
    starts = [place, *(int32(0) for _ in shape[1:])]
    row = read_windows(t, operand, place_windows(t, shape, starts, (1, *shape[1:])))
    return t.move(lambda x: x[0], row)


def write_row(t: Interpreter, operand: Value, place: Value, row: Value) -> Value:
    """Returns the operand with one row along the first axis replaced, clamped."""
    shape = operand.array.shape
    starts = [place, *(int32(0) for _ in shape[1:])]
    windows = place_windows(t, shape, starts, (1, *shape[1:]))
    windows = windows.clamped()
    return write_windows(t, operand, windows, row, "set")
