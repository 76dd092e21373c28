"""Rules and ranges, node by node."""

import math
from typing import Any

import numpy as np
import pytest

from mjxwalk.engines.lanes.ir.bounds import bounds
from mjxwalk.engines.lanes.ir.builder import GraphBuilder
from mjxwalk.engines.lanes.ir.graph import Graph
from mjxwalk.engines.lanes.ir.list_scheduling import ordered
from mjxwalk.engines.lanes.ir.semantics import REFERENCE, evaluate
from mjxwalk.engines.lanes.ir.simplify import simplifying


def inputs(build: GraphBuilder, count: int, dtype: str = "float32") -> list[int]:
    return [build.graph.add("input", dtype, (), (0, place)) for place in range(count)]


def test_equal_nodes_are_one() -> None:
    build = simplifying(Graph())
    x, y = inputs(build, 2)
    assert build.same("add", x, y) == build.same("add", y, x)
    assert build.same("sub", x, y) != build.same("sub", y, x)


def test_zeros_of_either_sign_and_nan_stay_apart() -> None:
    graph = Graph()
    nodes = {graph.constant(np.float32(v)) for v in (0.0, -0.0, math.nan, 1.0, 0.0)}
    assert len(nodes) == 4


IDENTITIES: dict[str, Any] = {
    "x + 0": lambda b, x, c: (b.same("add", x, c(0)), x),
    "0 + x": lambda b, x, c: (b.same("add", c(0), x), x),
    "x - 0": lambda b, x, c: (b.same("sub", x, c(0)), x),
    "x - x": lambda b, x, c: (b.same("sub", x, x), c(0)),
    "x * 1": lambda b, x, c: (b.same("mul", x, c(1)), x),
    "x * 0": lambda b, x, c: (b.same("mul", x, c(0)), c(0)),
    "x * -1": lambda b, x, c: (b.same("mul", x, c(-1)), b.same("neg", x)),
    "x * 2 * 3": lambda b, x, c: (
        b.same("mul", b.same("mul", x, c(2)), c(3)),
        b.same("mul", x, c(6)),
    ),
    "x ** 0": lambda b, x, c: (b.same("pow", x, c(0)), c(1)),
    "x ** 1": lambda b, x, c: (b.same("pow", x, c(1)), x),
    "x ** 3": lambda b, x, c: (b.same("pow", x, c(3)), b.same("mul", b.same("mul", x, x), x)),
    "x / 4": lambda b, x, c: (b.same("div", x, c(4)), b.same("mul", x, c(0.25))),
    "--x": lambda b, x, c: (b.same("neg", b.same("neg", x)), x),
    "max(x, x)": lambda b, x, c: (b.same("max", x, x), x),
    "max(max(x, 1), 3)": lambda b, x, c: (
        b.same("max", b.same("max", x, c(1)), c(3)),
        b.same("max", x, c(3)),
    ),
    "min(max(x, 0), 1) > -1": lambda b, x, c: (
        b.same("max", b.same("min", b.same("max", x, c(0)), c(1)), c(-1)),
        b.same("min", b.same("max", x, c(0)), c(1)),
    ),
    "x < 0 ? x : x": lambda b, x, c: (b.select(b.compare("lt", x, c(0)), x, x), x),
    "flag == 1": lambda b, x, c: (
        b.compare("eq", b.convert(b.compare("lt", x, c(0)), "float32"), c(1)),
        b.compare("lt", x, c(0)),
    ),
    "flag * x": lambda b, x, c: (
        b.same("mul", b.convert(b.compare("lt", x, c(0)), "float32"), x),
        b.select(b.compare("lt", x, c(0)), x, c(0)),
    ),
}


@pytest.mark.parametrize("name", IDENTITIES)
def test_identity_holds(name: str) -> None:
    build = simplifying(Graph())
    (x,) = inputs(build, 1)
    got, want = IDENTITIES[name](build, x, lambda value: build.constant(value, "float32"))
    assert got == want


def test_comparisons_of_floats_are_not_negated() -> None:
    build = simplifying(Graph())
    x, y = inputs(build, 2)
    assert build.op(build.same("not", build.compare("lt", x, y))) == "not"
    assert build.op(build.same("not", build.compare("eq", x, y))) == "ne"
    assert build.graph.value(build.compare("eq", x, x)) is None  # false for NaN


def test_constants_fold_in_their_own_arithmetic() -> None:
    build = simplifying(Graph())
    third = build.same("div", build.constant(1, "float32"), build.constant(3, "float32"))
    assert build.graph.value(third) == np.float32(1) / np.float32(3)
    top = build.constant(2**31 - 1, "int32")
    assert build.graph.value(build.same("add", top, build.constant(1, "int32"))) == -(2**31)


def test_bounds_hold_for_random_chains() -> None:
    rng = np.random.default_rng(5)
    ops = ["min", "max", "floor", "ceil", "neg", "abs", "add", "sub", "mul"]
    for _ in range(300):
        graph = Graph()
        x = graph.add("input", "float32", (), (0, 0))
        build, value = simplifying(graph), np.float32(rng.normal() * 10)
        node = build.same("max", x, build.constant(-20, "float32"))
        node, number = (
            build.same("min", node, build.constant(20, "float32")),
            np.clip(value, -20, 20),
        )
        for op in rng.choice(ops, 4).tolist():
            other = np.float32(rng.integers(-5, 6))
            more = () if op in ("floor", "ceil", "neg", "abs") else (other,)
            constants = [build.constant(float(o), "float32") for o in more]
            node = build.make(op, "float32", (node, *constants))
            number = REFERENCE[op](number, *more)
        low, high = bounds(graph, node)
        assert low <= number <= high or math.isclose(number, low) or math.isclose(number, high)


def test_conversion_and_division_are_total() -> None:
    odd = np.array([np.nan, np.inf, -np.inf, 1e30, -5.7], np.float32)
    np.testing.assert_array_equal(
        evaluate("convert", "int32", odd), [0, 2**31 - 1, -(2**31), 2**31 - 1, -5]
    )
    numbers = np.array([7, -7, -(2**31), 0], np.int32)
    divisors = np.array([0, 2, -1, 0], np.int32)
    got = evaluate("div", "int32", numbers, divisors), evaluate("rem", "int32", numbers, divisors)
    np.testing.assert_array_equal(got, [[-1, -3, -(2**31), -1], [7, -1, 0, 0]])


def test_order_keeps_every_step_after_what_it_needs() -> None:
    rng = np.random.default_rng(6)
    needs: dict[int, list[int]] = {step: [] for step in range(10)}
    for step in range(10, 400):
        needs[step] = sorted({int(rng.integers(step)), int(rng.integers(step))})
    order = ordered(list(needs), needs, dict.fromkeys(needs, "add"))
    place = {step: at for at, step in enumerate(order)}
    assert sorted(order) == list(needs)
    assert all(place[need] < place[step] for step in needs for need in needs[step])
