"""The code generator for XLA, against JAX and against the machine code."""

import dataclasses
import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engines.lanes.cases import (
    AXES,
    CONTROLLER,
    ENV,
    FUNCTIONS,
    GROUND,
    INTEGERS,
    INTS,
    STARTS,
    U,
    X,
    given,
    stroll,
    weights,
)
from jax import lax

from mjxwalk.engines import lanes, lanes_xla
from mjxwalk.rollout import rollout


def agree(function: Any, *args: Any, in_axes: Any = 0, rtol: Any = 2e-6, atol: Any = 2e-6) -> None:
    """Asserts that the scalar graph is the function; sums in another order round differently."""
    got = lanes_xla.vmap(function, in_axes)(*args)
    want = jax.jit(jax.vmap(function, in_axes))(*args)
    assert jax.tree.structure(got) == jax.tree.structure(want)
    for ours, theirs in zip(jax.tree.leaves(got), jax.tree.leaves(want), strict=True):
        assert (ours.shape, ours.dtype) == (theirs.shape, theirs.dtype)
        np.testing.assert_allclose(np.asarray(ours), np.asarray(theirs), rtol=rtol, atol=atol)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_function_agrees_with_jax(name: Any) -> None:
    """To 1e-5: a solve of five unknowns, and loops of two thousand steps, add up their rounding."""
    agree(FUNCTIONS[name], X, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("numbers", [INTS, U], ids=["signed", "unsigned"])
@pytest.mark.parametrize("name", INTEGERS)
def test_integers_agree_with_jax(name: Any, numbers: Any) -> None:
    j = np.roll(numbers, 1, 0)
    j[::3] = 0  # divisors of zero, distances of none
    agree(INTEGERS[name], numbers, j)


def test_walkers_that_end_at_different_steps_agree_with_the_machine_code() -> None:
    args = (STARTS, GROUND, (np.arange(203) % 3).astype(np.int32), np.int32(300))
    axes = (0, None, 0, None)
    ours, theirs = lanes_xla.vmap(stroll, axes)(*args), lanes.vmap(stroll, axes)(*args)
    same = np.asarray(ours[0]) == theirs[0]
    assert same.mean() > 0.95  # a walker within rounding of the end may take one step more
    np.testing.assert_allclose(np.asarray(ours[1])[same], theirs[1][same], rtol=1e-3, atol=1e-3)


def test_inner_loops_run_until_each_walker_has_had_enough() -> None:
    def function(w: Any) -> Any:
        def outer(state: Any) -> Any:
            i, total = state
            turns, total = lax.while_loop(
                lambda s: (s[0] < 5) & (s[1] < 2.0),
                lambda s: (s[0] + 1, s[1] * 1.5 + w),
                (0, total),
            )
            return i + turns + 1, total * 0.3

        return lax.while_loop(lambda s: s[0] < 20, outer, (0, jnp.abs(w)))

    agree(function, np.abs(STARTS), rtol=1e-5)


@pytest.mark.parametrize("own", [None, 0], ids=["shared", "own"])
def test_places_outside_a_table_are_clamped_as_in_the_machine_code(own: Any) -> None:
    indices = np.array([-(2**31), -51, -1, 0, 49, 50, 2**31 - 1], np.int32)
    tables = (
        GROUND[0]
        if own is None
        else np.random.default_rng(7).normal(size=(7, 50)).astype(np.float32)
    )

    def function(i: Any, table: Any) -> Any:
        return table[i], lax.dynamic_slice(table, (i,), (3,)), jnp.arange(40.0)[i]

    agree(function, indices, tables, in_axes=(0, own))


def test_a_leaf_of_none_is_no_argument() -> None:
    def function(weights: Any, gains: Any) -> Any:
        assert gains is None
        return weights["x"] * 2

    agree(function, {"x": X, "memory": None}, None)


def test_what_it_cannot_compile_it_refuses_as_the_machine_code_does() -> None:
    with pytest.raises(lanes.CannotCompileError, match=r"`eigh`.*test_lanes_xla\.py.*--engine mjx"):
        lanes_xla.vmap(lambda x: jnp.linalg.eigh(jnp.outer(x, x))[0])(X)
    with pytest.raises(ValueError, match="one batch size"):
        lanes_xla.vmap(lambda x, y: x + y)(X, X[:3])


@pytest.mark.slow
def test_short_trials_agree_with_the_machine_code_to_rounding() -> None:
    """A fifth of a second is before contact's chaos: 2e-5 m of some 0.3 m is 200 roundings."""
    env = dataclasses.replace(ENV, max_time=0.2)
    args = (weights(65, 0.3), given(65))  # no multiple of the number of devices
    trial = functools.partial(rollout, env, CONTROLLER)
    ours, theirs = lanes_xla.vmap(trial, AXES)(*args), lanes.vmap(trial, AXES)(*args)
    assert (np.asarray(ours.fell) == theirs.fell).all()
    np.testing.assert_allclose(np.asarray(ours.distance), theirs.distance, atol=2e-5)
    np.testing.assert_allclose(np.asarray(ours.work), theirs.work, rtol=1e-3)
