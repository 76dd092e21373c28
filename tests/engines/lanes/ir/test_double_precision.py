"""Functions in float64, against the C library's in the x87's 64 bits of precision."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import lax

from mjxwalk.engines import lanes

KEY = np.random.default_rng(0)
NUMBERS = np.concatenate(
    [KEY.uniform(-80, 80, 3_000), KEY.normal(size=1_000) * 10.0 ** KEY.uniform(-30, 0, 1_000)]
)
POSITIVE = 10.0 ** KEY.uniform(-300, 300, 4_000)
NEARLY_ONE = 1 + KEY.normal(size=2_000) * 10.0 ** KEY.uniform(-12, -1, 2_000)
UNIT = np.concatenate([KEY.uniform(-1, 1, 4_000), 1 - 10.0 ** KEY.uniform(-16, 0, 500)])
QUARTERS = np.arange(1, 2_000) * np.pi / 2
ANGLES = np.concatenate([NUMBERS, KEY.uniform(-1e5, 1e5, 4_000), QUARTERS])
SPECIAL = np.array([0.0, -0.0, 0.5, 1, -1, 2, -3, 2.5, 40, 1e300, 1e-300, np.inf, -np.inf, np.nan])
ULPS = 4.0

CASES: list[tuple[str, Any, Any, Any]] = [
    ("sin", jnp.sin, np.sin, ANGLES),
    ("cos", jnp.cos, np.cos, ANGLES),
    ("tan", jnp.tan, np.tan, ANGLES),
    ("exp", jnp.exp, np.exp, NUMBERS),
    ("exp2", jnp.exp2, np.exp2, NUMBERS),
    ("log", jnp.log, np.log, np.concatenate([POSITIVE, NEARLY_ONE])),
    ("expm1", jnp.expm1, np.expm1, NUMBERS),
    ("log1p", jnp.log1p, np.log1p, np.concatenate([POSITIVE, UNIT])),
    ("tanh", jnp.tanh, np.tanh, NUMBERS),
    ("sinh", jnp.sinh, np.sinh, NUMBERS),
    ("cosh", jnp.cosh, np.cosh, NUMBERS),
    ("asin", jnp.arcsin, np.arcsin, UNIT),
    ("acos", jnp.arccos, np.arccos, UNIT),
    ("atan", jnp.arctan, np.arctan, np.concatenate([NUMBERS, POSITIVE])),
    ("asinh", jnp.arcsinh, np.arcsinh, np.concatenate([NUMBERS, POSITIVE])),
    ("acosh", jnp.arccosh, np.arccosh, 1 + POSITIVE),
    ("atanh", jnp.arctanh, np.arctanh, UNIT),
    ("cbrt", jnp.cbrt, np.cbrt, np.concatenate([NUMBERS, POSITIVE])),
    ("logistic", lax.logistic, lambda x: 1 / (1 + np.exp(-x)), NUMBERS),
]
NAMES = [case[0] for case in CASES]


def worst(got: Any, want: Any) -> float:
    """Returns the largest error in units of the last place, where numbers are normal ones."""
    with np.errstate(over="ignore"):
        rounded = want.astype(np.float64)
    normal = (np.abs(rounded) > 1e-290) & np.isfinite(rounded)
    assert normal.sum() > 0.4 * len(want)
    error = np.abs(got.astype(np.longdouble) - want)[normal]
    return float((error / np.spacing(np.abs(rounded[normal]))).max())


@pytest.mark.parametrize("name, function, reference, points", CASES, ids=NAMES)
def test_function_is_accurate_to_a_few_units_in_the_last_place(
    name: str, function: Any, reference: Any, points: Any
) -> None:
    with jax.enable_x64(True):
        got = lanes.vmap(function)(points)
    assert got.dtype == np.float64
    assert worst(got, reference(points.astype(np.longdouble))) <= ULPS


@pytest.mark.parametrize("name, function, reference, points", CASES, ids=NAMES)
def test_function_has_the_right_limits(
    name: str, function: Any, reference: Any, points: Any
) -> None:
    edges = np.array([np.nan, np.inf, -np.inf, 0.0, -0.0, 1.0, -1.0])
    with jax.enable_x64(True), np.errstate(all="ignore"):
        np.testing.assert_allclose(
            lanes.vmap(function)(edges), reference(edges), rtol=1e-14, atol=1e-14
        )


def test_a_power_is_as_accurate_as_a_single_logarithm_would_not_be() -> None:
    x = np.concatenate([10.0 ** KEY.uniform(-3, 3, 5_000), 1 + KEY.normal(size=2_000) * 1e-3])
    y = np.concatenate([KEY.uniform(-80, 80, 5_000), KEY.normal(size=2_000) * 1e5])
    with jax.enable_x64(True):
        got = lanes.vmap(lax.pow)(x, y)
    assert worst(got, np.power(x.astype(np.longdouble), y.astype(np.longdouble))) <= ULPS


@pytest.mark.parametrize("pair", [(lax.pow, np.power), (jnp.arctan2, np.arctan2)])
def test_functions_of_two_numbers_have_the_cases_of_the_c_standard(pair: Any) -> None:
    x, y = (grid.ravel() for grid in np.meshgrid(SPECIAL, SPECIAL))
    with jax.enable_x64(True), np.errstate(all="ignore"):
        np.testing.assert_allclose(lanes.vmap(pair[0])(x, y), pair[1](x, y), rtol=1e-14)


def test_sine_of_an_absurd_angle_is_still_a_sine() -> None:
    with jax.enable_x64(True):
        sines = lanes.vmap(jnp.sin)(np.array([1e8, -3e15, 1e30, -3e300]))
    assert (np.abs(sines) <= 1.0).all()
