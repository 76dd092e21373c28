"""Sorting, as a network of comparisons: Batcher's odd-even merge sort.

K. E. Batcher (1968), Sorting networks and their applications. A network compares the same places
whatever the numbers are, about n log2(n)^2 / 4 pairs of them. Numbers become signed integers of the
same order. A network does not keep the order of equals, so places are compared after the keys
where that order shows. What nobody reads of a network is never computed, which is how the largest
few of many numbers are found.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from mjxwalk.engines.lanes.frontend.interpreter import (
    Handler,
    Interpreter,
    Known,
    Params,
    Refusal,
    Value,
)
from mjxwalk.engines.lanes.ir.graph import Array
from mjxwalk.engines.lanes.ir.semantics import is_float, is_signed

SMALL = ("bool", "uint8", "uint16")  # types whose numbers all are an int32


def network(size: int) -> Iterator[tuple[int, int]]:
    """Yields the pairs of places to be put in order one after the other, the lower place first."""
    half = 1
    while half < size:
        step = half
        while step >= 1:
            for start in range(step % half, size - step, 2 * step):
                for low in range(start, min(start + step, size - step)):
                    if low // (2 * half) == (low + step) // (2 * half):
                        yield low, low + step
            step //= 2
        half *= 2


def _sort(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    axis, num_keys = p["dimension"], p["num_keys"]
    arrays = [t.move(lambda x: np.moveaxis(x, axis, -1), value) for value in inputs]
    done = _sorted(t, arrays, num_keys, stable=p["is_stable"] and num_keys < len(inputs))
    return [t.move(lambda x: np.moveaxis(x, -1, axis), value) for value in done]


def _top_k(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return _largest(t, inputs[0], p["k"], p["axis"], least=False)


def _approx_top_k(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    """Returns the exact ones, which are approximate enough."""
    if not p["aggregate_to_topk"]:
        raise Refusal("keeps more numbers than k")
    return _largest(t, inputs[0], p["k"], p["reduction_dimension"], least=not p["is_max_k"])


def _largest(t: Interpreter, x: Value, k: int, axis: int, least: bool) -> list[Value]:
    """Returns the k largest (or least) numbers in XLA's total order, and their places."""
    x = t.move(lambda x: np.moveaxis(x, axis, -1), x)
    key = ordered(t, x, total=not least)
    if not least:
        key = t.apply("not", key.dtype, key)
    places = Known(_places(x.array.shape))
    done, places = _sorted(t, [key, places], 1, stable=True)
    if not least:
        done = t.apply("not", done.dtype, done)
    values = [disordered(t, done, x.dtype), places]
    return [t.move(lambda y: np.moveaxis(y[..., :k], -1, axis), value) for value in values]


def ordered(t: Interpreter, x: Value, total: bool = False) -> Value:
    """Returns signed integers in the order of the numbers: zeros are equal, NaN comes last.

    Args:
      total: whether -0 comes before 0, and NaN before or after all others by its sign.
    """
    if x.dtype in SMALL or is_signed(x.dtype):
        return t.apply("convert", _bits(x.dtype), x)
    bits = _bits(x.dtype)
    if not is_float(x.dtype):
        lowest = Known(np.array(np.iinfo(bits).min, bits))
        return t.apply("xor", bits, t.apply("convert", bits, x), lowest)
    if total:
        return _flipped(t, t.apply("bitcast", bits, x))
    zero = Known(np.zeros((), x.dtype))
    x = t.apply("select", x.dtype, t.apply("eq", "bool", x, zero), zero, x)
    key = _flipped(t, t.apply("bitcast", bits, x))
    highest = Known(np.array(np.iinfo(bits).max, bits))
    return t.apply("select", bits, t.apply("ne", "bool", x, x), highest, key)


def disordered(t: Interpreter, key: Value, dtype: str) -> Value:
    """Returns the numbers of a type that `ordered` made such integers of."""
    if dtype in SMALL or is_signed(dtype):
        return t.apply("convert", dtype, key)
    bits = _bits(dtype)
    if is_float(dtype):
        return t.apply("bitcast", dtype, _flipped(t, key))
    lowest = Known(np.array(np.iinfo(bits).min, bits))
    return t.apply("convert", dtype, t.apply("xor", bits, key, lowest))


def _flipped(t: Interpreter, key: Value) -> Value:
    """Returns the bits of floats as integers of their order, and the other way round."""
    bits = np.dtype(key.dtype).itemsize * 8
    sign = t.apply("sar", key.dtype, key, Known(np.array(bits - 1, key.dtype)))
    rest = Known(np.array(np.iinfo(key.dtype).max, key.dtype))
    return t.apply("xor", key.dtype, key, t.apply("and", key.dtype, sign, rest))


def _bits(dtype: str) -> str:
    return "int64" if np.dtype(dtype).itemsize == 8 else "int32"


def _places(shape: Sequence[int]) -> Array:
    return np.broadcast_to(np.arange(shape[-1], dtype=np.int32), shape)


def _sorted(t: Interpreter, arrays: Sequence[Value], num_keys: int, stable: bool) -> list[Value]:
    """Returns arrays sorted along their last axis by the first ones of them."""
    shape = arrays[0].array.shape
    keys = [ordered(t, x) for x in arrays[:num_keys]]
    places = Known(_places(shape))
    if stable:
        keys.append(places)
    free = [x for x in arrays[num_keys:] if not (stable and _is_same(x, places))]
    made = iter(_network(t, [*keys, *free], len(keys)))
    keys = [next(made) for _ in keys]
    places = keys[-1]
    done = [disordered(t, key, x.dtype) for key, x in zip(keys, arrays[:num_keys], strict=False)]
    for x in arrays[num_keys:]:
        left_out = stable and _is_same(x, Known(_places(shape)))
        done.append(t.apply("convert", x.dtype, places) if left_out else next(made))
    return done


def _is_same(x: Value, places: Known) -> bool:
    return (
        isinstance(x, Known)
        and x.array.dtype.kind in "iu"
        and np.array_equal(x.array, places.array)
    )


def _network(t: Interpreter, arrays: list[Value], num_keys: int) -> list[Value]:
    """Returns arrays sorted along their last axis by the first ones, integers that all differ or
    whose equals are alike."""
    build, moved = t.build, [t.nodes(value).copy() for value in arrays]
    for row in np.ndindex(moved[0].shape[:-1]):
        lines = [array[row] for array in moved]
        for low, high in network(moved[0].shape[-1]):
            pairs = [(int(line[low]), int(line[high])) for line in lines]
            if len(lines) == 1:
                lines[0][low], lines[0][high] = (
                    build.same("min", *pairs[0]),
                    build.same("max", *pairs[0]),
                )
                continue
            swap = _before(t, [(y, x) for x, y in pairs[:num_keys]])
            for line, (first, second) in zip(lines, pairs, strict=True):
                line[low] = build.select(swap, second, first)
                line[high] = build.select(swap, first, second)
    return [t.folded(ids, value.dtype) for ids, value in zip(moved, arrays, strict=True)]


def _before(t: Interpreter, pairs: list[tuple[int, int]]) -> int:
    """Returns whether the first of each pair sorts strictly before the second."""
    build = t.build
    before = build.constant(False, "bool")
    for x, y in reversed(pairs):
        equal = build.compare("eq", x, y)
        before = build.same("or", build.compare("lt", x, y), build.same("and", equal, before))
    return before


HANDLERS: dict[str, Handler] = {"sort": _sort, "top_k": _top_k, "approx_top_k": _approx_top_k}
