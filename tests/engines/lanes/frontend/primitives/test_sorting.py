"""Networks sort, keep the order of equals, and cost less than all pairs."""

import itertools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import lax

from mjxwalk.engines import lanes
from mjxwalk.engines.lanes.frontend.primitives.sorting import network

KEY = np.random.default_rng(0)
FLOATS = KEY.normal(size=(40, 9)).astype(np.float32)
FLOATS[::3] = np.round(FLOATS[::3])
FLOATS[5, 3] = np.nan
FLOATS[7, 1:4] = np.inf, np.nan, -np.inf
FLOATS[8, :5] = 0.0, -0.0, 0.0, -0.0, -1.0
UNSIGNED = KEY.integers(0, 1 << 32, (40, 9), np.uint32)
UNSIGNED[::2] >>= 29

FUNCTIONS: dict[str, Any] = {
    "sort": jnp.sort,
    "places": jnp.argsort,
    "places, downwards": lambda x: jnp.argsort(x, descending=True),
    "largest three": lambda x: lax.top_k(x, 3),
    "all, downwards": lambda x: lax.top_k(x, 9),
    "two keys": lambda x: lax.sort((x.astype(jnp.int32) % 3, x, jnp.arange(9)), num_keys=2),
    "keys and values": lambda x: lax.sort((x, x[::-1].astype(jnp.float32)), num_keys=1),
    "columns": lambda x: jnp.sort(jnp.stack([x, x[::-1]]), axis=0),
    "roughly": lambda x: lax.approx_max_k(x.astype(jnp.float32), 4, aggregate_to_topk=True),
}


@pytest.mark.parametrize("size", range(1, 13))
def test_a_network_that_sorts_zeros_and_ones_sorts_anything(size: int) -> None:
    """Knuth's principle: The Art of Computer Programming 3, section 5.3.4, theorem Z."""
    for numbers in itertools.product([0, 1], repeat=size):
        row = list(numbers)
        for low, high in network(size):
            row[low], row[high] = sorted((row[low], row[high]))
        assert row == sorted(numbers)


def agree(function: Any, x: Any) -> None:
    """Asserts that lanes sorts as JAX does."""
    got, want = lanes.vmap(function)(x), jax.jit(jax.vmap(function))(x)
    for ours, theirs in zip(jax.tree.leaves(got), jax.tree.leaves(want), strict=True):
        assert ours.dtype == theirs.dtype
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_sorting_agrees_with_jax(name: str) -> None:
    agree(FUNCTIONS[name], FLOATS)


@pytest.mark.parametrize("dtype", ["uint32", "int32", "int8", "uint16", "bool"])
def test_sorting_of_integers_agrees_with_jax(dtype: str) -> None:
    x = UNSIGNED % 2 == 1 if dtype == "bool" else UNSIGNED.astype(dtype)
    agree(lambda x: (jnp.sort(x), jnp.argsort(x, descending=True), lax.top_k(x, 3)), x)


@pytest.mark.parametrize("dtype", ["int64", "uint64", "float64"])
def test_sorting_of_64_bits_agrees_with_jax(dtype: str) -> None:
    with jax.enable_x64(True):
        x = np.where(np.isfinite(FLOATS), FLOATS * 100, 7)
        x = x.clip(0 if dtype == "uint64" else -50).astype(dtype)
        x[:, 7] = x[:, 2]
        agree(lambda x: (jnp.sort(x), jnp.argsort(x), lax.top_k(x, 3)), x)


def test_the_largest_few_of_many_cost_less_than_sorting_them() -> None:
    x = KEY.normal(size=(16, 64)).astype(np.float32)
    operations = []
    for function in (lambda x: lax.top_k(x, 4)[1], jnp.argsort, jnp.sort):
        mapped = lanes.vmap(function)
        mapped(x)
        assert mapped.compiled is not None
        operations.append(mapped.compiled.operations)
    few, places, alone = operations
    assert few < places
    assert alone < 64 * 63 / 2 * 7 / 5  # of a bubble sort, seven for each pair
