"""Functions without an instruction of their own, against numpy in float64 over wide ranges."""

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from jax import lax
from jax.scipy import special
from scipy.special import erf, erfc, erfinv

from mjxwalk.engines import lanes

KEY = np.random.default_rng(20)
WIDE = np.concatenate([KEY.normal(size=2_000), KEY.uniform(-80, 80, 2_000)]).astype(np.float32)
SMALL = (KEY.normal(size=1_000) * 10.0 ** KEY.uniform(-30, 0, 1_000)).astype(np.float32)
ANGLES = np.concatenate([WIDE, KEY.uniform(-1e5, 1e5, 4_000)]).astype(np.float32)
POSITIVE = (10.0 ** KEY.uniform(-37, 38, 4_000)).astype(np.float32)
NEARLY_ONE = (1 - 10.0 ** KEY.uniform(-7, 0, 1_000)).astype(np.float32)
UNIT = np.concatenate([KEY.uniform(-1, 1, 4_000), [-1, 1, 0]]).astype(np.float32)

# Bound in units of the last place of the result; an absolute error near a zero of sin, cos and tan
# is that of the range reduction, about 2**-24 of a radian.
CASES: list[tuple[str, Any, Any, Any, int, float]] = [
    ("sin", jnp.sin, np.sin, ANGLES, 2, 1e-7),
    ("cos", jnp.cos, np.cos, ANGLES, 2, 1e-7),
    ("tan", jnp.tan, np.tan, WIDE, 4, 2e-7),
    ("exp", jnp.exp, np.exp, WIDE, 2, 0),
    ("exp2", jnp.exp2, np.exp2, WIDE, 2, 0),
    ("expm1", jnp.expm1, np.expm1, np.concatenate([WIDE, SMALL]), 4, 0),
    ("log", jnp.log, np.log, POSITIVE, 2, 0),
    ("log1p", jnp.log1p, np.log1p, np.abs(np.concatenate([WIDE, SMALL])), 4, 0),
    ("tanh", jnp.tanh, np.tanh, np.concatenate([WIDE, SMALL]), 3, 0),
    ("sinh", jnp.sinh, np.sinh, np.concatenate([WIDE, SMALL]), 5, 0),
    ("cosh", jnp.cosh, np.cosh, WIDE, 3, 0),
    ("asin", jnp.arcsin, np.arcsin, UNIT, 3, 0),
    ("acos", jnp.arccos, np.arccos, UNIT, 3, 0),
    ("atan", jnp.arctan, np.arctan, np.concatenate([WIDE, SMALL, POSITIVE]), 3, 0),
    ("asinh", jnp.arcsinh, np.arcsinh, np.concatenate([WIDE, SMALL, POSITIVE]), 5, 0),
    ("acosh", jnp.arccosh, np.arccosh, np.concatenate([1 + np.abs(WIDE), 1 + POSITIVE]), 5, 0),
    ("atanh", jnp.arctanh, np.arctanh, UNIT[np.abs(UNIT) < 1], 5, 0),
    ("cbrt", jnp.cbrt, np.cbrt, np.concatenate([WIDE, POSITIVE]), 2, 0),
    ("sqrt", jnp.sqrt, np.sqrt, POSITIVE, 1, 0),
    ("rsqrt", lax.rsqrt, lambda x: 1 / np.sqrt(x), POSITIVE, 3, 0),
    ("erf", lax.erf, erf, np.concatenate([WIDE, UNIT]), 4, 4e-7),
    ("erfc", lax.erfc, erfc, WIDE, 12, 0),
    ("erf_inv", lax.erf_inv, erfinv, np.concatenate([UNIT, SMALL, NEARLY_ONE, -NEARLY_ONE]), 4, 0),
    ("logistic", special.expit, lambda x: 1 / (1 + np.exp(-x)), WIDE, 4, 0),
]
NAMES = [case[0] for case in CASES]


@pytest.mark.parametrize("width", [4, 16])
@pytest.mark.parametrize("name, function, reference, points, ulps, slack", CASES, ids=NAMES)
def test_function_is_accurate_to_a_few_units_in_the_last_place(
    width: Any, name: Any, function: Any, reference: Any, points: Any, ulps: Any, slack: Any
) -> None:
    got = lanes.vmap(function, width=width)(points)
    want = reference(points.astype(np.float64))
    with np.errstate(over="ignore"):
        spacing = np.spacing(np.abs(want).astype(np.float32)).astype(np.float64)
    normal = (np.abs(want) >= np.finfo(np.float32).tiny) & (np.abs(want) < 3.4e38)
    error = np.abs(got[normal] - want[normal])
    worst = (error - slack).clip(0) / spacing[normal]
    assert worst.max() <= ulps, (name, points[normal][worst.argmax()], worst.max())
    assert np.abs(got[~normal & (np.abs(want) < 1)]).max(initial=0) <= np.finfo(np.float32).tiny


@pytest.mark.parametrize("name, function, reference, points, ulps, slack", CASES, ids=NAMES)
def test_function_has_the_right_limits(
    name: Any, function: Any, reference: Any, points: Any, ulps: Any, slack: Any
) -> None:
    edges = np.array([np.nan, np.inf, -np.inf, 0.0, -0.0, 1.0, -1.0], np.float32)
    got = lanes.vmap(function)(edges)
    with np.errstate(all="ignore"):
        want = reference(edges.astype(np.float64)).astype(np.float32)
    np.testing.assert_allclose(got, want, rtol=1e-6, atol=1e-6, err_msg=name)


@pytest.mark.parametrize("function", [jnp.sin, jnp.cos])
def test_sine_of_an_absurd_angle_is_still_a_sine(function: Any) -> None:
    angles = np.array([1e8, -3e15, 1e30, -3e38, 5e7], np.float32)
    assert (np.abs(lanes.vmap(function)(angles)) <= 1.0).all()


def test_atan2_is_right_in_every_quadrant_and_on_every_axis() -> None:
    values = np.array([0.0, -0.0, 1, -1, 2.5, -1e-20, 1e30, np.inf, -np.inf, np.nan], np.float32)
    y, x = (grid.ravel() for grid in np.meshgrid(values, values))
    np.testing.assert_allclose(lanes.vmap(jnp.arctan2)(y, x), np.arctan2(y, x), rtol=4e-7)


def test_pow_has_the_cases_of_the_c_standard() -> None:
    values = np.array([0.0, 0.5, 1, -1, 2, -2, 3, -3, 2.5, -0.5, 40, np.inf, -np.inf], np.float32)
    x, y = (grid.ravel() for grid in np.meshgrid(values, values))
    with np.errstate(all="ignore"):
        want = np.power(x.astype(np.float64), y.astype(np.float64)).astype(np.float32)
    np.testing.assert_allclose(lanes.vmap(lax.pow)(x, y), want, rtol=2e-7)
