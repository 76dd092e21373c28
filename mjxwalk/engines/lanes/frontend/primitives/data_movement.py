"""Primitives that move numbers about: numpy applied to ids."""

from collections.abc import Callable

import numpy as np

from mjxwalk.engines.lanes.frontend.interpreter import Handler, Interpreter, Params, Value
from mjxwalk.engines.lanes.ir.graph import Array


def _broadcast_in_dim(x: Array, p: Params) -> Array:
    shape, dimensions = p["shape"], p["broadcast_dimensions"]
    aligned = [1] * len(shape)
    for size, dimension in zip(x.shape, dimensions, strict=True):
        aligned[dimension] = size
    return np.broadcast_to(x.reshape(aligned), shape)


def _slice(x: Array, p: Params) -> Array:
    strides = p["strides"] or (1,) * x.ndim
    window = zip(p["start_indices"], p["limit_indices"], strides, strict=True)
    return x[tuple(slice(*bounds) for bounds in window)]


def _pad(x: Array, fill: Array, p: Params) -> Array:
    config = p["padding_config"]
    shape = [low + high + size + max(size - 1, 0) * gap
             for size, (low, high, gap) in zip(x.shape, config, strict=True)]  # fmt: skip
    # Negative edges cut: fill a frame that is large enough, then take the window asked for.
    lows = [max(low, 0) for low, _, _ in config]
    frame = [size + max(low, 0) - low + max(high, 0) - high
             for size, (low, high, _) in zip(shape, config, strict=True)]  # fmt: skip
    padded = np.full(frame, fill, x.dtype)
    where = tuple(
        slice(low, low + max(size - 1, 0) * (gap + 1) + 1 if size else low, gap + 1)
        for low, size, (_, _, gap) in zip(lows, x.shape, config, strict=True)
    )
    padded[where] = x
    cut = [max(-low, 0) for low, _, _ in config]
    return padded[tuple(slice(c, c + size) for c, size in zip(cut, shape, strict=True))]


def _reshape(x: Array, p: Params) -> Array:
    order = p["dimensions"]
    return (x if order is None else x.transpose(order)).reshape(p["new_sizes"])


ONE: dict[str, Callable[[Array, Params], Array]] = {
    "broadcast_in_dim": _broadcast_in_dim,
    "reshape": _reshape,
    "squeeze": lambda x, p: x.squeeze(p["dimensions"]),
    "expand_dims": lambda x, p: np.expand_dims(x, p["dimensions"]),
    "transpose": lambda x, p: x.transpose(p["permutation"]),
    "rev": lambda x, p: np.flip(x, p["dimensions"]),
    "slice": _slice,
    "tile": lambda x, p: np.tile(x, p["reps"]),
}
SAME = ("copy", "copy_p", "stop_gradient", "sharding_constraint", "pvary", "reshard", "name")


def _one(mover: Callable[[Array, Params], Array]) -> Handler:
    def handler(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
        return [t.move(lambda x: mover(x, p), inputs[0])]

    return handler


def _same(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return inputs


def _concatenate(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return [t.move(lambda *xs: np.concatenate(xs, p["dimension"]), *inputs)]


def _stack(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return [t.move(lambda *xs: np.stack(xs, p["axis"]), *inputs)]


def _split(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    ends = np.cumsum(p["sizes"])
    return [
        t.move(lambda x, i=i: np.split(x, ends[:-1], p["axis"])[i], inputs[0])
        for i in range(len(ends))
    ]


def _unstack(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    axis = p["axis"]
    rows = range(inputs[0].array.shape[axis])
    return [t.move(lambda x, row=row: x.take(row, axis), inputs[0]) for row in rows]


def _padding(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return [t.move(lambda x, fill: _pad(x, fill, p), *inputs)]


def _iota(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    shape, axis = p["shape"], p["dimension"]
    column = np.arange(shape[axis]).reshape([-1 if i == axis else 1 for i in range(len(shape))])
    return [t.known(np.broadcast_to(column, shape).astype(p["dtype"]))]


HANDLERS: dict[str, Handler] = {
    **{name: _one(mover) for name, mover in ONE.items()},
    **dict.fromkeys(SAME, _same),
    "optimization_barrier": _same,
    "concatenate": _concatenate,
    "stack": _stack,
    "split": _split,
    "unstack": _unstack,
    "pad": _padding,
    "iota": _iota,
}
