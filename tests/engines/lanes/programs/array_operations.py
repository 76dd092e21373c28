"""Operations of random programs on whole arrays: shapes, sums, products, places, sorting."""

from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
from engines.lanes.programs.operations import (
    ANY,
    FLOATS,
    INTEGERS,
    NUMBERS,
    Choice,
    Draw,
    Operation,
    infinite,
    not_finite,
    pick,
)
from engines.lanes.programs.program import Kind
from hypothesis import strategies as st
from jax import lax


def _array(draw: Draw, kinds: Sequence[Kind], dtypes: Sequence[str] = ANY, rank: int = 1) -> int:
    """Returns the number of a value with at least so many axes."""
    return pick(draw, kinds, lambda k: k.dtype in dtypes and len(k.shape) >= rank)


def _along_axis(dtypes: Sequence[str], **parameters: Any) -> Callable[..., Choice]:
    def choose(draw: Draw, kinds: Sequence[Kind]) -> Choice:
        x = _array(draw, kinds, dtypes)
        axis = draw(st.integers(0, len(kinds[x].shape) - 1))
        return (x,), (axis, *map(draw, parameters.values()))

    return choose


def _choose_joined(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = _array(draw, kinds)
    dtype, shape = kinds[x]
    y = pick(
        draw, kinds, lambda k: k.dtype == dtype and k.shape[1:] == shape[1:] and len(k.shape) > 0
    )
    if shape[0] + kinds[y].shape[0] > 8:
        y = x
    return (x, y), ()


def _choose_stacked(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = pick(draw, kinds, lambda k: len(k.shape) < 2)
    return (x, pick(draw, kinds, lambda k: k == kinds[x])), ()


def _choose_padding(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = pick(draw, kinds, lambda k: len(k.shape) == 1)
    fill = pick(draw, kinds, lambda k: k == Kind(kinds[x].dtype, ()))
    return (x, fill), (draw(st.integers(-1, 2)), draw(st.integers(-1, 2)), draw(st.integers(0, 1)))


def _choose_slice(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = _array(draw, kinds)
    size = kinds[x].shape[0]
    start = draw(st.integers(0, size - 1)) if size else 0
    return (x,), (start, draw(st.integers(start, size)), draw(st.sampled_from([1, 2])))


SHAPES = {
    "rows": Operation(_choose_slice, lambda p, x: x[p[0] : p[1] : p[2]]),
    "ravel": Operation(lambda d, k: ((_array(d, k),), ()), lambda p, x: jnp.ravel(x)),
    "transpose": Operation(lambda d, k: ((_array(d, k, rank=2),), ()), lambda p, x: x.T),
    "reverse": Operation(_along_axis(ANY), lambda p, x: jnp.flip(x, p[0])),
    "roll": Operation(_along_axis(ANY), lambda p, x: jnp.roll(x, 1, p[0])),
    "column": Operation(lambda d, k: ((_array(d, k),), ()), lambda p, x: x[..., None]),
    "stretch": Operation(
        lambda d, k: ((pick(d, k, lambda q: len(q.shape) < 2),), (d(st.sampled_from([1, 2, 3])),)),
        lambda p, x: jnp.broadcast_to(x, (p[0], *x.shape)),
    ),
    "join": Operation(_choose_joined, lambda p, x, y: jnp.concatenate([x, y])),
    "stack": Operation(_choose_stacked, lambda p, x, y: jnp.stack([x, y], -1)),
    "pad": Operation(_choose_padding, lambda p, x, fill: lax.pad(x, fill, [p])),
}


def _order_decides(arrays: Sequence[Any], result: Any) -> Any:
    """A sum or a product may pass the range of its type on the way, in some order of its terms."""
    x = arrays[0]
    if not jnp.issubdtype(x.dtype, jnp.floating):
        return False
    size = jnp.abs(x)
    lost = jnp.prod(jnp.where(x == 0, 1, jnp.minimum(size, 1))) < jnp.finfo(x.dtype).tiny
    return not_finite(x, jnp.sum(size), jnp.prod(jnp.maximum(size, 1))) | lost


REDUCTIONS = {
    "sum": Operation(_along_axis(NUMBERS), lambda p, x: jnp.sum(x, p[0], x.dtype), 2, sums=True,
                     doubt=_order_decides),
    "prod": Operation(_along_axis(NUMBERS), lambda p, x: jnp.prod(x, p[0], x.dtype), 8,
                      doubt=_order_decides),
    "largest": Operation(_along_axis(ANY), lambda p, x: lax.reduce_max(x, (p[0],))),
    "smallest": Operation(_along_axis(ANY), lambda p, x: lax.reduce_min(x, (p[0],))),
    "all": Operation(_along_axis(("bool",)), lambda p, x: jnp.all(x, p[0])),
    "any": Operation(_along_axis(("bool",)), lambda p, x: jnp.any(x, p[0])),
    "parity": Operation(_along_axis(INTEGERS), lambda p, x: lax.reduce_xor(x, (p[0],))),
    "argmax": Operation(_along_axis(NUMBERS), lambda p, x: lax.argmax(x, p[0], jnp.int32)),
    "argmin": Operation(_along_axis(NUMBERS), lambda p, x: lax.argmin(x, p[0], jnp.int32)),
    "cumsum": Operation(
        _along_axis(NUMBERS, back=st.booleans()),
        lambda p, x: lax.cumsum(x, p[0], p[1]), 2, sums=True, doubt=_order_decides,
    ),
    "cumprod": Operation(
        _along_axis(NUMBERS, back=st.booleans()),
        lambda p, x: lax.cumprod(x, p[0], p[1]), 8, doubt=_order_decides,
    ),
    "cummax": Operation(
        _along_axis(NUMBERS, back=st.booleans()), lambda p, x: lax.cummax(x, p[0], p[1])
    ),
    "cummin": Operation(
        _along_axis(NUMBERS, back=st.booleans()), lambda p, x: lax.cummin(x, p[0], p[1])
    ),
}  # fmt: skip


def _choose_product(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = _array(draw, kinds, NUMBERS)
    dtype, shape = kinds[x]
    y = pick(
        draw, kinds, lambda k: k.dtype == dtype and len(k.shape) > 0 and k.shape[0] == shape[-1]
    )
    return (x, y), ()


def _choose_batch(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = _array(draw, kinds, FLOATS, rank=2)
    return (x, pick(draw, kinds, lambda k: k == kinds[x])), ()


def _choose_factor(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = pick(draw, kinds, lambda k: k.dtype in FLOATS and len(k.shape) == 2)
    return (x,), ()


def _choose_triangular(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    a = pick(
        draw, kinds, lambda k: k.dtype in FLOATS and len(k.shape) == 2 and k.shape[0] == k.shape[1]
    )
    left = draw(st.booleans())
    dtype, (size, _) = kinds[a]
    b = pick(
        draw, kinds,
        lambda k: k.dtype == dtype and len(k.shape) == 2 and k.shape[0 if left else 1] == size,
    )  # fmt: skip
    return (a, b), (left, *(draw(st.booleans()) for _ in range(3)))


def _definite(x: jax.Array) -> jax.Array:
    """Returns a matrix whose Cholesky factor is well determined."""
    small = x / (1 + jnp.max(jnp.abs(x), initial=0))
    return small @ small.T + jnp.eye(len(x), dtype=x.dtype)


def _solve(p: Any, a: jax.Array, b: jax.Array) -> jax.Array:
    left, lower, transposed, unit = p
    size = len(a)
    a = a / (1 + jnp.max(jnp.abs(a), initial=0)) + 2 * jnp.eye(size, dtype=a.dtype)
    return lax.linalg.triangular_solve(
        a, b, left_side=left, lower=lower, transpose_a=transposed, unit_diagonal=unit
    )


PRODUCTS = {
    "product": Operation(_choose_product, lambda p, x, y: x @ y if x.ndim < 3 and y.ndim < 3 else
                         jnp.tensordot(x, y, 1), 2, sums=True, doubt=infinite),
    "inner": Operation(
        _choose_batch, lambda p, x, y: jnp.einsum("i...,i...->i", x, y), 2, sums=True,
        doubt=infinite,
    ),
    "cholesky": Operation(
        _choose_factor, lambda p, x: lax.linalg.cholesky(_definite(x)), 8, 8, sums=True,
        doubt=lambda xs, r: not_finite(*xs) | jnp.any(jnp.abs(xs[0]) > 1e15),
    ),
    "solve": Operation(_choose_triangular, _solve, 8, sums=True,
                       doubt=lambda xs, r: not_finite(*xs) | jnp.any(jnp.abs(xs[0]) > 1e15)),
}  # fmt: skip


def _choose_place(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = _array(draw, kinds)
    at = pick(
        draw, kinds, lambda k: k.dtype in ("int32", "uint32", "int8", "int64") and len(k.shape) < 2
    )
    return (x, at), (draw(st.sampled_from(["clip", "fill", "promise_in_bounds", "wrap"])),)


def _choose_window(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = _array(draw, kinds)
    at = pick(draw, kinds, lambda k: k.dtype in ("int32", "uint32", "int64") and k.shape == ())
    size = kinds[x].shape[0]
    return (x, at), (draw(st.integers(min(1, size), size)),)


def _choose_updated(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = _array(draw, kinds)
    dtype, shape = kinds[x]
    at = pick(draw, kinds, lambda k: k.dtype == "int32" and k.shape == ())
    y = pick(draw, kinds, lambda k: k.dtype == dtype and len(k.shape) == len(shape)
             and k.shape[0] <= shape[0] and k.shape[1:] == shape[1:])  # fmt: skip
    return (x, y, at), ()


def _choose_written(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    how = draw(st.sampled_from(["set", "add", "multiply", "min", "max", "subtract"]))
    x = _array(draw, kinds, ANY if how in ("set", "min", "max") else NUMBERS)
    dtype, shape = kinds[x]
    at = pick(draw, kinds, lambda k: k.dtype in ("int32", "uint32") and len(k.shape) < 2)
    y = pick(draw, kinds, lambda k: k.dtype == dtype
             and k.shape in ((), shape[1:], (*kinds[at].shape, *shape[1:])))  # fmt: skip
    if how == "set" and kinds[at].shape:
        y = pick(draw, kinds, lambda k: k.dtype == dtype and k.shape in ((), shape[1:]))
    return (x, at, y), (how, draw(st.sampled_from(["clip", "drop", "promise_in_bounds"])))


def _place(x: jax.Array, at: jax.Array, mode: str) -> jax.Array:
    """Returns a place that the mode defines: a promise has to be kept."""
    return jnp.clip(at, 0, max(len(x) - 1, 0)) if mode == "promise_in_bounds" else at


def _read(p: Any, x: jax.Array, at: jax.Array) -> jax.Array:
    if p[0] == "wrap":
        return jnp.take(x, at, 0, mode="wrap")
    return x.at[_place(x, at, p[0])].get(mode=p[0])


def _write(p: Any, x: jax.Array, at: jax.Array, y: jax.Array) -> jax.Array:
    return getattr(x.at[_place(x, at, p[1])], p[0])(y, mode=p[1])


def _choose_pairs(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = _array(draw, kinds, NUMBERS)
    y = pick(draw, kinds, lambda k: k.shape == kinds[x].shape)
    return (x, y), (draw(st.sampled_from([1, 2])), draw(st.integers(0, 1)))


def _choose_largest(draw: Draw, kinds: Sequence[Kind]) -> Choice:
    x = _array(draw, kinds, NUMBERS)
    size = kinds[x].shape[-1]
    return (x,), (draw(st.integers(min(1, size), size)), draw(st.integers(0, 1)))


PLACES = {
    "read": Operation(_choose_place, _read),
    "window": Operation(
        _choose_window,
        lambda p, x, at: lax.dynamic_slice(x, (at, *[0] * (x.ndim - 1)), (p[0], *x.shape[1:])),
    ),
    "update": Operation(
        _choose_updated,
        lambda p, x, y, at: lax.dynamic_update_slice(x, y, (at, *[0] * (x.ndim - 1))),
    ),
    "write": Operation(_choose_written, _write, 2, sums=True,
                       doubt=lambda xs, r: infinite((xs[0], xs[2]), r)),
    "sort": Operation(_along_axis(ANY), lambda p, x: lax.sort(x, dimension=p[0])),
    "argsort": Operation(
        _along_axis(NUMBERS, down=st.booleans()),
        lambda p, x: jnp.argsort(x, p[0], descending=p[1]).astype(jnp.int32),
    ),
    "largest few": Operation(
        _choose_largest, lambda p, x: lax.top_k(x, p[0])[p[1]],
        doubt=lambda xs, r: jnp.any((xs[0] == 0) | (xs[0] != xs[0])),  # in order of their signs
    ),
    "sort pairs": Operation(
        _choose_pairs,
        lambda p, x, y: lax.sort((x, y), dimension=-1, num_keys=p[0])[p[1]],
    ),
}  # fmt: skip
