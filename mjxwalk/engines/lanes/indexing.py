"""Gather, scatter and slices at places that may depend on the walker.

All of them address windows: a place in the operand for each window, and steps within it that are
the same for all. Where the places are known, the rest is numpy. Where a walker computes them, a
read becomes a clamped load from the input's memory or from a table of constants, or a tree of
selects over computed numbers; a write becomes a select per number that it could reach.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from mjxwalk.engines.lanes.graph import Array
from mjxwalk.engines.lanes.scalars import is_float, is_signed
from mjxwalk.engines.lanes.tracing import (
    ARGUMENT,
    Equation,
    Handler,
    Known,
    Nodes,
    Refusal,
    Tracer,
    Value,
)

Params = dict[str, Any]
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


def _windows(
    t: Tracer, shape: Sequence[int], starts: Sequence[Value], sizes: Sequence[int]
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


def _asint32(t: Tracer, start: Value) -> Value:
    """Returns an index as int32, an unsigned one that is too large as the largest."""
    if start.dtype.startswith("uint"):
        top = Known(np.asarray(np.iinfo(np.int32).max).astype(start.dtype))
        start = t.apply("min", start.dtype, start, top) if start.dtype > "uint16" else start
    return t.apply("convert", "int32", start)


def _read(t: Tracer, operand: Value, windows: Windows) -> Value:
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


def _at(t: Tracer, operand: Value, place: int, step: int) -> int:
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


def _choose(t: Tracer, choices: list[int], place: int) -> int:
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


def _write(t: Tracer, operand: Value, windows: Windows, updates: Value, combine: str) -> Value:
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


def _component(t: Tracer, indices: Value, number: int) -> Value:
    return t.move(lambda x: x[..., number], indices)


def _starts(
    t: Tracer,
    rank: int,
    indices: Value,
    index_map: Sequence[int],
    operand_batch: Sequence[int],
    index_batch: Sequence[int],
) -> list[Value]:
    """Returns the start along each operand axis for an index array whose last axis is a place."""
    shape = indices.array.shape[:-1]
    starts: list[Value] = [Known(np.zeros(shape, np.int32)) for _ in range(rank)]
    for number, axis in enumerate(index_map):
        starts[axis] = _component(t, indices, number)
    for axis, batch in zip(operand_batch, index_batch, strict=True):
        starts[axis] = Known(np.indices(shape, np.int32)[batch])
    return starts


def _ints(numbers: Sequence[Any]) -> tuple[int, ...]:
    """Returns a primitive's parameter as plain integers, which it not always is."""
    return tuple(map(int, numbers))


def _mode(p: Params) -> str:
    return str(p["mode"]).rpartition(".")[2].lower()


def _gather(t: Tracer, p: Params, inputs: list[Value], equation: Equation) -> list[Value]:
    operand, indices = inputs
    d = p["dimension_numbers"]
    shape = operand.array.shape
    batches = _ints(d.operand_batching_dims), _ints(d.start_indices_batching_dims)
    starts = _starts(t, len(shape), indices, _ints(d.start_index_map), *batches)
    windows = _windows(t, shape, starts, _ints(p["slice_sizes"]))
    if operand.array.size == 0:  # nothing to read: only an empty result makes sense
        return [Known(np.zeros(equation.outvars[0].aval.shape, operand.dtype))]
    read = _read(t, operand, windows)
    if "fill" in _mode(p):
        fill = Known(np.asarray(_fill_value(p["fill_value"], operand.dtype), operand.dtype))
        window_axes = (1,) * windows.steps.ndim
        inside = t.move(lambda x: x.reshape(x.shape + window_axes), windows.inside)
        if not (isinstance(inside, Known) and inside.array.all()):
            read = t.apply("select", operand.dtype, inside, read, fill)
    batch = indices.array.ndim - 1
    dropped = (*d.collapsed_slice_dims, *d.operand_batching_dims)
    axes = tuple(batch + axis for axis in dropped)
    rank = read.array.ndim - len(axes)
    order = _interleaved(rank, _ints(d.offset_dims), batch)
    return [t.move(lambda x: x.squeeze(axes).transpose(order), read)]


def _interleaved(rank: int, window_axes: Sequence[int], batch: int) -> list[int]:
    """Returns the order that brings [batch..., window...] to where the window axes belong."""
    windows, batches = iter(range(batch, rank)), iter(range(batch))
    return [next(windows) if axis in window_axes else next(batches) for axis in range(rank)]


def _fill_value(given: Any, dtype: str) -> Any:
    if given is not None:
        return given
    if is_float(dtype):
        return np.nan
    if dtype == "bool":
        return True
    return np.iinfo(dtype).min if is_signed(dtype) else np.iinfo(dtype).max


def _scatter(combine: str) -> Handler:
    def handler(t: Tracer, p: Params, inputs: list[Value], equation: Equation) -> list[Value]:
        operand, indices, updates = inputs
        d = p["dimension_numbers"]
        shape, batch = operand.array.shape, indices.array.ndim - 1
        dropped = (*d.inserted_window_dims, *d.operand_batching_dims)
        spans = iter(updates.array.shape[axis] for axis in d.update_window_dims)
        sizes = [1 if axis in dropped else next(spans) for axis in range(len(shape))]
        starts = _starts(t, len(shape), indices, _ints(d.scatter_dims_to_operand_dims),
                         _ints(d.operand_batching_dims),
                         _ints(d.scatter_indices_batching_dims))  # fmt: skip
        windows = _windows(t, shape, starts, sizes)
        if "clip" in _mode(p):
            windows = dataclasses.replace(windows, inside=_everywhere(windows.inside))
        order = np.argsort(_interleaved(updates.array.ndim, _ints(d.update_window_dims), batch))
        updates = t.move(lambda x: x.transpose(order), updates)
        return [_write(t, operand, windows, updates, combine)]

    return handler


def _everywhere(inside: Value) -> Known:
    return Known(np.ones(inside.array.shape, np.bool_))


def _dynamic_slice(t: Tracer, p: Params, inputs: list[Value], equation: Equation) -> list[Value]:
    operand, *starts = inputs
    windows = _windows(t, operand.array.shape, starts, _ints(p["slice_sizes"]))
    return [_read(t, operand, windows)]


def _dynamic_update(t: Tracer, p: Params, inputs: list[Value], equation: Equation) -> list[Value]:
    operand, update, *starts = inputs
    windows = _windows(t, operand.array.shape, starts, update.array.shape)
    windows = dataclasses.replace(windows, inside=_everywhere(windows.inside))
    return [_write(t, operand, windows, update, "set")]


def read_row(t: Tracer, operand: Value, place: Value) -> Value:
    """Returns operand[place] along the first axis, clamped."""
    shape = operand.array.shape
    starts = [place, *(int32(0) for _ in shape[1:])]
    row = _read(t, operand, _windows(t, shape, starts, (1, *shape[1:])))
    return t.move(lambda x: x[0], row)


def write_row(t: Tracer, operand: Value, place: Value, row: Value) -> Value:
    """Returns the operand with one row along the first axis replaced, clamped."""
    shape = operand.array.shape
    starts = [place, *(int32(0) for _ in shape[1:])]
    windows = _windows(t, shape, starts, (1, *shape[1:]))
    windows = dataclasses.replace(windows, inside=_everywhere(windows.inside))
    return _write(t, operand, windows, row, "set")


HANDLERS: dict[str, Handler] = {
    "gather": _gather,
    "dynamic_slice": _dynamic_slice,
    "dynamic_update_slice": _dynamic_update,
    "scatter": _scatter("set"),
    "scatter-add": _scatter("add"),
    "scatter_add": _scatter("add"),
    "scatter-sub": _scatter("sub"),
    "scatter_sub": _scatter("sub"),
    "scatter_mul": _scatter("mul"),
    "scatter-mul": _scatter("mul"),
    "scatter_min": _scatter("min"),
    "scatter-min": _scatter("min"),
    "scatter_max": _scatter("max"),
    "scatter-max": _scatter("max"),
}
