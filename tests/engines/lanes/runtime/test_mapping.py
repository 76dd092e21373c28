"""`lanes.vmap` against `jax.jit(jax.vmap)`."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engines.lanes.cases import FUNCTIONS, INTEGERS, INTS, U, X
from jax import lax

from mjxwalk.engines import lanes

B = X > 0


class Pair(NamedTuple):
    """A tree to come back as it went in."""

    first: jax.Array
    second: tuple[jax.Array, None]


def agree(
    function: Any,
    *args: Any,
    in_axes: Any = 0,
    rtol: Any = 2e-6,
    atol: Any = 2e-6,
    width: Any = None,
) -> None:
    """Asserts that both compile the same function; rounding may differ by fused operations."""
    got = lanes.vmap(function, in_axes, width=width)(*args)
    want = jax.jit(jax.vmap(function, in_axes))(*args)
    assert jax.tree.structure(got) == jax.tree.structure(want)
    for ours, theirs in zip(jax.tree.leaves(got), jax.tree.leaves(want), strict=True):
        assert (ours.shape, ours.dtype) == (theirs.shape, theirs.dtype)
        np.testing.assert_allclose(ours, np.asarray(theirs), rtol=rtol, atol=atol)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_function_agrees_with_jax(name: Any) -> None:
    agree(FUNCTIONS[name], X, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("width", [4, 8, 16])
@pytest.mark.parametrize("name", ["arithmetic", "logic", "conversion", "solve", "fori", "sorting"])
def test_every_width_gives_the_same(name: Any, width: Any) -> None:
    agree(FUNCTIONS[name], X, width=width, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("numbers", [INTS, U], ids=["signed", "unsigned"])
@pytest.mark.parametrize("name", INTEGERS)
def test_integers_agree_with_jax(name: Any, numbers: Any) -> None:
    j = np.roll(numbers, 1, 0)
    j[::3] = 0  # divisors of zero, distances of none
    agree(INTEGERS[name], numbers, j)


def test_the_lowest_integer_by_minus_one_does_not_trap() -> None:
    lowest = np.full(3, np.iinfo(np.int32).min, np.int32)
    agree(lambda i, j: (lax.div(i, j), lax.rem(i, j)), lowest, np.full(3, -1, np.int32))


def test_conversion_to_integers_clamps_and_sends_nan_to_zero() -> None:
    points = np.array([np.nan, np.inf, -np.inf, 3e9, -3e9, 2147483520.0, 1.9, -1.9], np.float32)
    agree(lambda x: (x.astype(jnp.int32), x.astype(jnp.uint32), x.astype(jnp.int8)), points)


@pytest.mark.parametrize("extreme", [jnp.maximum, jnp.minimum])
def test_extremes_pass_nan_on_from_either_side(extreme: Any) -> None:
    x = np.array([np.nan, 1.0, np.nan, 2.0], np.float32)
    y = np.array([1.0, np.nan, np.nan, 3.0], np.float32)
    agree(extreme, x, y)
    agree(lambda x: extreme(x, 0.5), x)


def test_trees_and_axes_are_those_of_vmap() -> None:
    def function(pair: Any, scale: Any, *, shift: Any) -> Any:
        return Pair(pair["a"].sum() * scale + shift, (pair["b"], None))

    args = ({"a": X.T, "b": INTS}, np.float32(3))
    mapped = lanes.vmap(function, ({"a": 1, "b": 0}, None))
    got = mapped(*args, shift=X[:, 0])
    want = jax.vmap(function, ({"a": 1, "b": 0}, None))(*args, shift=X[:, 0])
    assert isinstance(got, Pair) and got.second[1] is None
    np.testing.assert_allclose(got.first, want.first, rtol=1e-6)
    np.testing.assert_array_equal(got.second[0], want.second[0])


def test_a_tree_of_none_has_no_axis() -> None:
    agree(lambda p: p["x"] + 1, {"x": X, "unused": None})


def test_booleans_go_in_and_out() -> None:
    agree(lambda b: (b, ~b, b.sum(), jnp.where(b, 1, 2)), B)


def test_numpy_doubles_become_what_jax_makes_of_them() -> None:
    assert lanes.vmap(lambda x: x * 2)(X.astype(np.float64)).dtype == np.float32


def test_it_runs_inside_jit() -> None:
    def total(x: Any) -> Any:
        return lanes.vmap(lambda y: (y * 2).sum())(x) + 1

    np.testing.assert_allclose(jax.jit(total)(X), total(X), rtol=1e-6)


def test_no_walkers_give_empty_results() -> None:
    assert lanes.vmap(lambda x: x.sum())(X[:0]).shape == (0,)


def test_unequal_axes_are_refused() -> None:
    with pytest.raises(ValueError, match="one size, got"):
        lanes.vmap(lambda x, y: x + y)(X, X[:3])


def test_an_unknown_primitive_is_refused_with_its_name_and_line() -> None:
    with pytest.raises(lanes.CannotCompileError, match=r"`eigh`.*test_mapping\.py.*--engine mjx"):
        lanes.vmap(lambda x: jnp.linalg.eigh(jnp.outer(x, x))[0])(X)
