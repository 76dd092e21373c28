"""Gather, scatter and slices, as reads and writes of windows."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mjxwalk.engines.lanes.frontend.interpreter import Handler, Interpreter, Known, Params, Value
from mjxwalk.engines.lanes.frontend.primitives.windows import (
    place_windows,
    read_windows,
    write_windows,
)
from mjxwalk.engines.lanes.ir.semantics import is_float, is_signed


def _component(t: Interpreter, indices: Value, number: int) -> Value:
    return t.move(lambda x: x[..., number], indices)


def _starts(
    t: Interpreter,
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


def _gather(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    operand, indices = inputs
    d = p["dimension_numbers"]
    shape = operand.array.shape
    batches = _ints(d.operand_batching_dims), _ints(d.start_indices_batching_dims)
    starts = _starts(t, len(shape), indices, _ints(d.start_index_map), *batches)
    windows = place_windows(t, shape, starts, _ints(p["slice_sizes"]))
    read = read_windows(t, operand, windows)
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
    def handler(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
        operand, indices, updates = inputs
        d = p["dimension_numbers"]
        shape, batch = operand.array.shape, indices.array.ndim - 1
        dropped = (*d.inserted_window_dims, *d.operand_batching_dims)
        spans = iter(updates.array.shape[axis] for axis in d.update_window_dims)
        sizes = [1 if axis in dropped else next(spans) for axis in range(len(shape))]
        starts = _starts(t, len(shape), indices, _ints(d.scatter_dims_to_operand_dims),
                         _ints(d.operand_batching_dims),
                         _ints(d.scatter_indices_batching_dims))  # fmt: skip
        windows = place_windows(t, shape, starts, sizes)
        if "clip" in _mode(p):
            windows = windows.clamped()
        order = np.argsort(_interleaved(updates.array.ndim, _ints(d.update_window_dims), batch))
        updates = t.move(lambda x: x.transpose(order), updates)
        return [write_windows(t, operand, windows, updates, combine)]

    return handler


def _dynamic_slice(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    operand, *starts = inputs
    windows = place_windows(t, operand.array.shape, starts, _ints(p["slice_sizes"]))
    return [read_windows(t, operand, windows)]


def _dynamic_update(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    operand, update, *starts = inputs
    windows = place_windows(t, operand.array.shape, starts, update.array.shape)
    windows = windows.clamped()
    return [write_windows(t, operand, windows, update, "set")]


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
