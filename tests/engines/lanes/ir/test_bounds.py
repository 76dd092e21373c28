"""Ranges drop clamps and comparisons only where no number can leave them."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.engines import lanes
from mjxwalk.engines.lanes.ir.bounds import bounds
from mjxwalk.engines.lanes.ir.graph import Graph
from mjxwalk.engines.lanes.ir.simplify import simplifying

UNSIGNED = np.array([0, 1, 7, 2**31, 2**32 - 2, 2**32 - 1], np.uint32)


@pytest.mark.parametrize("mode", ["clip", "fill", "wrap"])
def test_an_unsigned_place_above_2_to_31_stays_inside_the_table(mode: Any) -> None:
    def function(place: Any, table: Any) -> Any:
        return jnp.take(table, place, mode=mode), table.at[place].add(1.0, mode="clip")

    table = np.arange(50, dtype=np.float32)
    for own in (None, 0):
        tables = table if own is None else np.tile(table, (len(UNSIGNED), 1))
        got = lanes.vmap(function, (0, own))(UNSIGNED, tables)
        want = jax.jit(jax.vmap(function, (0, own)))(UNSIGNED, tables)
        for ours, theirs in zip(got, want, strict=True):
            np.testing.assert_array_equal(ours, theirs)


def test_an_integer_from_nan_is_zero_whatever_its_range() -> None:
    def function(x: Any) -> Any:
        number = jnp.maximum(x, 5.0).astype(jnp.int32)
        return number, number >= 5, jnp.maximum(number, 3)

    x = np.array([np.nan, 3.0, 7.0], np.float32)
    for ours, theirs in zip(lanes.vmap(function)(x), jax.vmap(function)(x), strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_a_narrower_float_keeps_its_fraction() -> None:
    def function(x: Any) -> Any:
        return jnp.maximum(jnp.clip(x, -0.7, 0.7).astype(jnp.float32), -0.5)

    with jax.enable_x64(True):
        x = np.array([-2.0, -0.6, 0.3])
        np.testing.assert_array_equal(lanes.vmap(function)(x), jax.vmap(function)(x))


def test_a_sum_may_pass_its_range_by_the_rounding_of_a_product() -> None:
    build = simplifying(Graph())
    x, y = (build.graph.add("input", "float32", (), (n, 0)) for n in range(2))
    one, part = build.constant(1, "float32"), build.constant(0.1, "float32")
    below = build.same("min", x, part)
    product = build.same("mul", below, build.same("min", build.same("max", y, part), one))
    _, high = bounds(build.graph, build.same("add", product, build.constant(0.2, "float32")))
    assert 0.3 < high < 0.3000001


def test_a_wrapping_conversion_has_the_range_of_its_type() -> None:
    build = simplifying(Graph())
    x = build.graph.add("input", "uint32", (), (0, 0))
    assert bounds(build.graph, build.convert(x, "int32")) == (-(2.0**31), 2.0**31 - 1)
    low = build.same("and", x, build.constant(7, "uint32"))
    assert bounds(build.graph, build.convert(low, "int32")) == (0.0, 7.0)
