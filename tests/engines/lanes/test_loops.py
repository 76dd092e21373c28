"""Loops: refilled lanes, masks, invariants, and what must not depend on anything else."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engines.lanes.cases import GROUND, STARTS, stroll
from jax import lax

from mjxwalk.engines import lanes
from mjxwalk.engines.lanes.frontend.primitives import sizes
from mjxwalk.engines.lanes.frontend.tracing import trace
from mjxwalk.engines.lanes.ir.graph import LoopId, reachable, regions
from mjxwalk.engines.lanes.ir.signature import Argument

KEY = np.random.default_rng(11)


def strolls(starts: Any, **settings: Any) -> Any:
    rows = (np.arange(len(starts)) % 3).astype(np.int32)
    mapped = lanes.vmap(stroll, (0, None, 0, None), **settings)
    return mapped(starts, GROUND, rows, 300), mapped


def bits(tree: Any) -> Any:
    """Returns every number's bits, so that NaN equals NaN and zeros have signs."""
    return [np.asarray(leaf).view(np.uint32) for leaf in jax.tree.leaves(tree)]


def operations(mapped: lanes.Mapped) -> int:
    """Returns how many operations a step of the latest call took."""
    return mapped.compiled.operations if mapped.compiled else 0


@pytest.mark.parametrize("width", [4, 8, 16])
def test_walkers_that_end_at_different_steps_agree_with_jax(width: Any) -> None:
    rows = (np.arange(203) % 3).astype(np.int32)
    want = jax.jit(jax.vmap(stroll, (0, None, 0, None)))(STARTS, GROUND, rows, 300)
    got, _ = strolls(STARTS, width=width)
    same = got[0] == np.asarray(want[0])
    assert same.mean() > 0.95  # a walker within rounding of the end may take one step more
    np.testing.assert_allclose(got[1][same], np.asarray(want[1])[same], rtol=1e-3, atol=1e-3)


def test_bits_do_not_depend_on_threads() -> None:
    one, _ = strolls(STARTS, threads=1)
    for threads in (2, 5):
        many, _ = strolls(STARTS, threads=threads)
        for first, second in zip(bits(one), bits(many), strict=True):
            np.testing.assert_array_equal(first, second)


def test_bits_do_not_depend_on_the_batch_or_the_lane() -> None:
    whole, mapped = strolls(STARTS)
    order = KEY.permutation(203)[:61]
    some = mapped(STARTS[order], GROUND, (order % 3).astype(np.int32), 300)
    for first, second in zip(bits(whole), bits(some), strict=True):
        np.testing.assert_array_equal(first[order], second)


def test_absurd_walkers_leave_their_neighbours_alone() -> None:
    whole, _ = strolls(STARTS)
    mixed = STARTS.copy()
    mixed[::4] = np.resize([np.nan, np.inf, -np.inf, 1e30, -3e38, 1e-45], 51)
    others, _ = strolls(mixed)
    untouched = np.arange(203) % 4 != 0
    for first, second in zip(bits(whole), bits(others), strict=True):
        np.testing.assert_array_equal(first[untouched], second[untouched])


def test_utilisation_counts_the_lanes_that_had_a_walker() -> None:
    mapped = lanes.vmap(lambda n: lax.while_loop(lambda i: i < n, lambda i: i + 1, 0),
                        width=4, threads=1)  # fmt: skip
    assert (mapped(np.full(8, 10, np.int32)) == 10).all()
    assert mapped.utilisation == 1.0
    mapped(np.array([10, 10, 10, 10, 10], np.int32))
    assert mapped.utilisation == 50 / 80  # the fifth walks alone


def test_a_walker_that_never_starts_has_its_initial_state() -> None:
    mapped = lanes.vmap(lambda n: lax.while_loop(lambda i: i < n, lambda i: i + 1, 7))
    np.testing.assert_array_equal(
        mapped(np.arange(20, dtype=np.int32)), np.maximum(np.arange(20), 7)
    )


def test_inner_loops_run_until_each_lane_has_had_enough() -> None:
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

    got, want = lanes.vmap(function)(np.abs(STARTS)), jax.vmap(function)(np.abs(STARTS))
    np.testing.assert_array_equal(got[0], want[0])
    np.testing.assert_allclose(got[1], want[1], rtol=1e-5)


def test_inner_loops_stay_inside_when_an_outer_carry_never_changes() -> None:
    def function(w: Any) -> Any:
        def outer(state: Any) -> Any:
            i, total, fixed = state
            inner = lax.while_loop(lambda y: y < total + 1, lambda y: y + fixed, total * 0.5)
            return i + 1, inner * 0.7, fixed * 1.0  # which JAX itself does not see through

        return lax.while_loop(lambda s: s[0] < 5, outer, (0, w, 0.25))[1]

    got, want = lanes.vmap(function)(STARTS), jax.vmap(function)(STARTS)
    np.testing.assert_allclose(got, want, rtol=1e-5, atol=1e-6)


def test_a_test_may_read_what_two_loops_around_it_carry() -> None:
    def function(w: Any) -> Any:
        def outer(state: Any) -> Any:
            def middle(held: Any) -> Any:
                count, sum_ = held
                far = jnp.abs(sum_) + jnp.abs(state[1]) + 1
                return count + 1, lax.while_loop(lambda y: y < far, lambda y: y * 1.5 + 1, 0.0) / 9

            return state[0] + 1, lax.while_loop(lambda s: s[0] < 3, middle, (0, state[1]))[1]

        return lax.while_loop(lambda s: s[0] < 5, outer, (0, w))[1]

    got, want = lanes.vmap(function)(STARTS), jax.vmap(function)(STARTS)
    np.testing.assert_allclose(got, want, rtol=1e-5)


def test_a_loop_whose_test_has_a_loop_agrees_with_jax() -> None:
    def function(x: Any) -> Any:
        def test(total: Any) -> Any:
            return lax.while_loop(lambda i: i < total, lambda i: i * 1.5 + 1, 0.0) < 20

        return lax.while_loop(test, lambda total: total + 1, x)

    np.testing.assert_array_equal(lanes.vmap(function)(STARTS), jax.vmap(function)(STARTS))


def test_a_loop_in_a_branch_runs_only_for_those_who_take_it() -> None:
    def endless(x: Any) -> Any:  # never ends unless x is positive
        return lax.while_loop(lambda y: y < 10, lambda y: y + x, x)

    def function(x: Any) -> Any:
        return lax.cond(x > 0.1, endless, lambda y: y, x)

    np.testing.assert_allclose(lanes.vmap(function)(STARTS),
                               [function(x) for x in STARTS], rtol=1e-5)  # fmt: skip


def test_loops_one_after_another_agree_with_jax() -> None:
    def function(x: Any) -> Any:
        a = lax.while_loop(lambda y: y < 3, lambda y: y * 1.1 + 0.1, jnp.abs(x))
        b = lax.while_loop(lambda s: s[1] < 40, lambda s: (jnp.sin(s[0]) + a, s[1] + 1), (x, 0))[0]
        return a, lax.while_loop(lambda y: y < a + b, lambda y: y + 1.0, x)

    got, want = lanes.vmap(function)(STARTS), jax.vmap(function)(STARTS)
    for ours, theirs in zip(got, want, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-4)


def test_carries_that_never_change_and_that_nobody_reads_cost_nothing() -> None:
    def lean(x: Any) -> Any:
        return lax.while_loop(lambda s: s[1] < 9, lambda s: (s[0] * x, s[1] + 1), (x, 0))[0]

    def fat(x: Any) -> Any:
        def step(s: Any) -> Any:
            power, count, constant, unread = s
            return power * constant, count + 1, constant, unread * 1.1 + power

        return lax.while_loop(lambda s: s[1] < 9, step, (x, 0, x, x))[0]

    one, other = lanes.vmap(lean), lanes.vmap(fat)
    np.testing.assert_array_equal(one(STARTS), other(STARTS))
    assert operations(one) == operations(other)


@pytest.mark.parametrize("index", [-1000, -51, -3, 0, 49, 50, 2**31 - 1])
def test_every_index_stays_inside_the_table(index: Any) -> None:
    def function(i: Any, table: Any) -> Any:
        place = (i,)
        return (
            table[i],
            table.at[place].get(mode="fill"),
            lax.dynamic_slice(table, place, (3,)),
            jnp.take(table, i, mode="clip"),
        )

    table, indices = GROUND[0], np.full(5, index, np.int32)
    for own in (None, 0):
        tables = table if own is None else np.tile(table, (5, 1))
        got = lanes.vmap(function, (0, own))(indices, tables)
        want = jax.jit(jax.vmap(function, (0, own)))(indices, tables)
        for ours, theirs in zip(got, want, strict=True):
            np.testing.assert_array_equal(ours, theirs)


def test_arrays_written_at_computed_places_agree_with_jax() -> None:
    def function(x: Any, i: Any) -> Any:
        values = jnp.stack([x, x * 2, x * 3, x * 4, -x])
        return (
            values.at[i].set(9.0),
            values.at[i].add(x),
            lax.dynamic_update_slice(values, jnp.stack([x, x]), (i,)),
            values[i],
            jnp.arange(40.0)[i],
        )

    i = KEY.integers(-8, 9, 203).astype(np.int32)
    got, want = lanes.vmap(function)(STARTS, i), jax.jit(jax.vmap(function))(STARTS, i)
    for ours, theirs in zip(got, want, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-6)


def test_writing_a_large_array_at_a_computed_place_is_refused() -> None:
    with pytest.raises(
        lanes.CannotCompileError, match=r"scatter.*places that each walker computes"
    ):
        lanes.vmap(lambda i: jnp.zeros(100_000).at[i].set(1.0).sum())(np.arange(3))


def long_branch(x: Any) -> Any:
    for _ in range(10):
        x = jnp.sin(1.1 * x) + 0.1
    return x


def by_turns(x: Any, count: Any) -> Any:
    """Walkers take a long branch in different steps, and some of them end before others."""

    def step(state: Any) -> Any:
        turn, x = state
        due = (turn + count) % 3 == 0
        x, extra = jax.lax.cond(
            due, lambda x: (long_branch(x), x[0]), lambda x: (0.9 * x, jnp.float32(0.0)), x
        )
        x = jax.lax.switch(
            turn % 3, [lambda x: x, lambda x: long_branch(x)[::-1], lambda x: -x], x + extra
        )
        return turn + 1, x

    return jax.lax.while_loop(lambda state: state[0] < 4 + count, step, (0, x))[1]


def test_a_branch_that_no_walker_takes_is_passed_over() -> None:
    x = np.random.default_rng(0).normal(size=(37, 20)).astype(np.float32)
    count = np.arange(37, dtype=np.int32) % 5
    found = lanes.vmap(by_turns)(x, count)
    np.testing.assert_allclose(found, jax.jit(jax.vmap(by_turns))(x, count), atol=2e-5)
    graph = trace(
        by_turns,
        jax.tree.structure(((0, 0), {})),
        [Argument((20,), "float32", False, False), Argument((), "int32", False, False)],
    ).graph
    main, *branches = graph.loops.values()
    assert len(branches) == 2
    live = reachable(graph, main.following.values())
    where = regions(graph, live)
    long = [node for node in live if graph.nodes[node].op == "sin"]
    assert len(long) == 2 * 10 * 20
    assert {graph.loops[where[node]].parent for node in long} == {LoopId(0)}


def test_a_long_branch_counts_the_numbers_that_it_makes_alone() -> None:
    moved = jax.make_jaxpr(lambda x: jnp.concatenate([x, x[::-1]]).reshape(2, -1).T)(jnp.ones(900))
    assert sizes.work(moved) == 0
    product = jax.make_jaxpr(lambda x: jax.jit(lambda y: y @ y)(x))(jnp.ones((4, 4)))
    assert sizes.work(product) == 4**3
