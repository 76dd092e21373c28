"""Tests of the mjx engine."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.engines import mjx


def collatz(start: jax.Array, limit: jax.Array) -> dict[str, jax.Array]:
    """Counts the steps to one: a loop of another length for every walker."""

    def step(carry: tuple[jax.Array, jax.Array]) -> tuple[jax.Array, jax.Array]:
        value, count = carry
        return jnp.where(value % 2 == 0, value // 2, 3 * value + 1), count + 1

    value, count = jax.lax.while_loop(
        lambda carry: (carry[0] > 1) & (carry[1] < limit), step, (start, jnp.asarray(0))
    )
    return {"value": value, "count": count}


def test_it_maps_as_vmap_does_over_several_devices() -> None:
    assert len(jax.devices()) > 1
    starts = jnp.arange(1, 28)  # no multiple of the number of devices
    ours = mjx.vmap(collatz, in_axes=(0, None))(starts, jnp.asarray(500))
    reference = jax.vmap(collatz, in_axes=(0, None))(starts, jnp.asarray(500))
    jax.tree.map(np.testing.assert_array_equal, ours, reference)
    assert int(ours["count"][26]) == 111  # the famous 27


def test_it_compiles_once_for_each_set_of_shapes() -> None:
    mapped = mjx.vmap(collatz)
    mapped(jnp.arange(1, 5), jnp.full(4, 100))
    compiled = mapped.compile_s
    mapped(jnp.arange(5, 9), jnp.full(4, 100))
    assert mapped.compile_s == compiled > 0
    mapped(jnp.arange(1, 9), jnp.full(8, 100))
    assert mapped.compile_s > compiled


def test_batches_of_different_sizes_are_refused() -> None:
    with pytest.raises(ValueError, match=r"one batch size, got \[3, 4\]"):
        mjx.vmap(collatz)(jnp.arange(3), jnp.arange(4))


def test_a_batch_that_is_not_in_front_is_refused() -> None:
    with pytest.raises(ValueError, match="in_axes must be 0 or None, got 1"):
        mjx.vmap(collatz, in_axes=(1, None))(jnp.ones((2, 3)), jnp.asarray(5))
