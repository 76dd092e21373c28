"""One walker a thread: the kernel for GPUs, on the CPU, against JAX and against the lanes."""

import dataclasses
import functools
from typing import Any

import jax
import numpy as np
import pytest
from engines.lanes import cpu_threads, test_arrays
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

from mjxwalk.engines import lanes
from mjxwalk.rollout import rollout

# Operations are those of the lanes; here matter their types, loops, loads and stores.
QUICK = ("comparisons", "constant", "conversion", "empty products", "fori", "sorting", "switch")
NETWORKS = {function.__name__: function for function in test_arrays.FUNCTIONS}
SMALL = ("masked", "waiting")
SUBNORMAL = ("bits as floats",)  # which the GPU alone takes for zero


def slow(name: str) -> Any:
    return pytest.param(name, marks=pytest.mark.slow)


def agree(function: Any, *args: Any, in_axes: Any = 0, tolerance: float = 2e-6) -> None:
    """Asserts that the kernel is the function; rounding may differ by fused operations."""
    got = cpu_threads.vmap(function, in_axes)(*args)
    want = jax.jit(jax.vmap(function, in_axes))(*args)
    assert jax.tree.structure(got) == jax.tree.structure(want)
    for ours, theirs in zip(jax.tree.leaves(got), jax.tree.leaves(want), strict=True):
        assert (ours.shape, ours.dtype) == (theirs.shape, theirs.dtype)
        np.testing.assert_allclose(ours, np.asarray(theirs), rtol=tolerance, atol=tolerance)


@pytest.mark.parametrize("name", [n if n in QUICK else slow(n) for n in FUNCTIONS])
def test_function_agrees_with_jax(name: Any) -> None:
    """To 1e-5: a solve of five unknowns, and loops of two thousand steps, add up their rounding."""
    agree(FUNCTIONS[name], X, tolerance=1e-5)


@pytest.mark.parametrize("numbers", [INTS, U], ids=["signed", "unsigned"])
@pytest.mark.parametrize("name", [n for n in INTEGERS if n not in SUBNORMAL])
def test_integers_agree_with_jax(name: Any, numbers: Any) -> None:
    j = np.roll(numbers, 1, 0)
    j[::3] = 0  # divisors of zero, distances of none
    agree(INTEGERS[name], numbers, j)


def test_walkers_that_end_at_different_steps_agree_with_the_lanes() -> None:
    args = (STARTS, GROUND, (np.arange(203) % 3).astype(np.int32), np.int32(300))
    axes = (0, None, 0, None)
    ours, theirs = cpu_threads.vmap(stroll, axes)(*args), lanes.vmap(stroll, axes)(*args)
    same = ours[0] == theirs[0]
    assert same.mean() > 0.95  # a walker within rounding of the end may take one step more
    np.testing.assert_allclose(ours[1][same], theirs[1][same], rtol=1e-3, atol=1e-3)


def test_loops_within_loops_run_for_as_long_as_each_walker_wants() -> None:
    def function(w: Any) -> Any:
        def outer(state: Any) -> Any:
            i, total = state
            turns, total = jax.lax.while_loop(
                lambda s: (s[0] < 5) & (s[1] < 2.0),
                lambda s: (s[0] + 1, s[1] * 1.5 + w),
                (0, total),
            )
            return i + turns + 1, total * 0.3

        return jax.lax.while_loop(lambda s: s[0] < 20, outer, (0, abs(w)))

    agree(function, np.abs(STARTS), tolerance=1e-5)


def test_a_table_of_truths_is_read() -> None:
    table, places = np.arange(50) % 3 == 0, np.arange(19, dtype=np.int32)
    agree(lambda place: jax.numpy.asarray(table)[place], places)


@pytest.mark.parametrize("own", [None, 0], ids=["shared", "own"])
def test_places_outside_a_table_are_clamped(own: Any) -> None:
    indices = np.array([-(2**31), -51, -1, 0, 49, 50, 2**31 - 1], np.int32)
    tables = np.random.default_rng(7).normal(size=(7, 50)).astype(np.float32)

    def function(i: Any, table: Any) -> Any:
        return table[i], jax.lax.dynamic_slice(table, (i,), (3,)), jax.numpy.arange(40.0)[i]

    agree(function, indices, GROUND[0] if own is None else tables, in_axes=(0, own))


@pytest.mark.parametrize("name", [n if n in SMALL else slow(n) for n in NETWORKS])
def test_large_products_agree_with_jax(name: str) -> None:
    agree(NETWORKS[name], *test_arrays.drawn(), tolerance=2e-5)


@pytest.mark.slow
def test_short_trials_agree_with_the_lanes_to_rounding() -> None:
    """A fifth of a second is before contact's chaos: 2e-5 m of some 0.3 m is 200 roundings."""
    trial = functools.partial(rollout, dataclasses.replace(ENV, max_time=0.2), CONTROLLER)
    args = (weights(65, 0.3), given(65))
    ours, theirs = cpu_threads.vmap(trial, AXES)(*args), lanes.vmap(trial, AXES)(*args)
    assert (ours.fell == theirs.fell).all()
    np.testing.assert_allclose(ours.distance, theirs.distance, atol=2e-5)
    np.testing.assert_allclose(ours.work, theirs.work, rtol=1e-3)
