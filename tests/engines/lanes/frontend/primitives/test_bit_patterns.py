"""Counts of bits, neighbours and smaller formats are exactly JAX's."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import lax

from mjxwalk.engines import lanes

KEY = np.random.default_rng(4)
SPECIAL = np.array([0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan, 3.4e38, 65504, 1e-7], np.float32)
X = np.concatenate([SPECIAL, KEY.normal(size=90) * 10.0 ** KEY.uniform(-9, 9, 90)]).astype("f4")
Y = np.roll(X, 1) * np.where(KEY.random(100) < 0.3, 0, 1).astype(np.float32)
INTEGERS = KEY.integers(0, 1 << 64, 100, np.uint64) >> KEY.integers(0, 64, 100).astype(np.uint64)


@pytest.mark.parametrize("dtype", ["int8", "uint16", "int32", "uint32", "int64", "uint64"])
def test_bits_are_counted_as_in_jax(dtype: Any) -> None:
    with jax.enable_x64(dtype.endswith("64")):
        x = INTEGERS.astype(dtype)
        x[:2] = 0, -1 if dtype[0] == "i" else 1
        for function in (lax.population_count, lax.clz):
            np.testing.assert_array_equal(lanes.vmap(function)(x), function(x))


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_the_next_number_is_that_of_jax(dtype: Any) -> None:
    with jax.enable_x64(dtype == "float64"):
        x, y = X.astype(dtype), Y.astype(dtype)
        got = lanes.vmap(jnp.nextafter)(x, y)
        with np.errstate(all="ignore"):
            want = np.nextafter(x, y)
        subnormal = np.abs(want) < np.finfo(dtype).tiny  # as bits here, as zero for JAX
        np.testing.assert_array_equal(got, want)
        np.testing.assert_array_equal(got[~subnormal], jnp.nextafter(x, y)[~subnormal])


@pytest.mark.parametrize("bits", [(8, 23), (8, 7), (5, 10), (4, 3), (8, 22), (3, 23)])
def test_smaller_formats_are_those_of_jax(bits: Any) -> None:
    function = lambda x: lax.reduce_precision(x, *bits)  # noqa: E731
    np.testing.assert_array_equal(lanes.vmap(function)(X), jax.jit(function)(X))


def test_places_in_a_sorted_table_are_those_of_jax() -> None:
    table = np.sort(X[7:40])

    def function(x: Any) -> Any:
        return jnp.searchsorted(table, x), jnp.searchsorted(table, x, side="right")

    for ours, theirs in zip(lanes.vmap(function)(X), jax.vmap(function)(X), strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_a_reshape_may_reorder_axes_first() -> None:
    function = lambda x: lax.reshape(x, (6,), dimensions=(1, 0))  # noqa: E731
    x = KEY.normal(size=(5, 2, 3)).astype(np.float32)
    np.testing.assert_array_equal(lanes.vmap(function)(x), jax.vmap(function)(x))


def test_rows_are_taken_apart() -> None:
    x = KEY.normal(size=(5, 2, 3)).astype(np.float32)
    got, want = lanes.vmap(jnp.unstack)(x), jax.vmap(jnp.unstack)(x)
    for ours, theirs in zip(got, want, strict=True):
        np.testing.assert_array_equal(ours, theirs)
