"""What the compiler cannot do it refuses by name; what it does with nothing is what JAX does."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import lax

from mjxwalk.engines import lanes

X = np.linspace(-1.0, 1.0, 12, dtype=np.float32).reshape(4, 3)
PLACES = np.arange(4, dtype=np.int32)
NONE = jnp.zeros((0,), jnp.int32)

EMPTY: dict[str, Any] = {
    "scatter nothing": lambda x, i: x.at[NONE].set(jnp.zeros((0,))),
    "scatter nothing at a computed place": lambda x, i: (
        jnp.zeros((3, 2)).at[NONE + i].add(jnp.zeros((0, 2)) + x[0])
    ),
    "scatter into nothing": lambda x, i: jnp.zeros((0,)).at[NONE + i].add(x[:0]),
    "scatter empty windows": lambda x, i: jnp.zeros((3, 0)).at[i].set(jnp.zeros(0)),
    "gather nothing": lambda x, i: x[NONE + i],
    "gather from nothing": lambda x, i: x[:0][NONE + i],
    "slice": lambda x, i: lax.dynamic_slice(x, (i,), (0,)),
    "update": lambda x, i: lax.dynamic_update_slice(x, x[:0], (i,)),
    "sum": lambda x, i: x[:0].sum(),
    "product": lambda x, i: x[:0].prod(),
    "all": lambda x, i: (x[:0] > 0).all(),
    "any": lambda x, i: (x[:0] > 0).any(),
    "largest of booleans": lambda x, i: jnp.max(x > 0),
    "largest, with a first": lambda x, i: jnp.max(x[:0], initial=-3.0),
    "rows of nothing": lambda x, i: (jnp.zeros((2, 0)) + x[0]).sum(1),
    "no rows": lambda x, i: (jnp.zeros((0, 2)) + x[0]).sum(0),
    "product over nothing": lambda x, i: (jnp.zeros((2, 0)) + x[0]) @ (jnp.zeros((0, 2)) + x[0]),
    "product of no rows": lambda x, i: (jnp.zeros((0, 3)) + x[0]) @ x,
    "concatenate": lambda x, i: jnp.concatenate([x[:0], x, x[3:]]),
    "sort": lambda x, i: jnp.sort(x[:0]),
    "running sum": lambda x, i: jnp.cumsum(x[:0]),
    "no matrices": lambda x, i: jnp.linalg.cholesky(jnp.zeros((0, 2, 2)) + x[0]),
    "empty matrix": lambda x, i: jnp.linalg.cholesky(jnp.zeros((0, 0)) + x[0]),
    "no right-hand sides": lambda x, i: jax.scipy.linalg.solve_triangular(
        jnp.eye(2) * (2 + x[0]), jnp.zeros((2, 0)), lower=True
    ),
    "loop that carries nothing": lambda x, i: lax.while_loop(
        lambda c: c[0] < 3, lambda c: (c[0] + 1, c[1]), (i, x[:0])
    ),
    "no steps": lambda x, i: lax.scan(lambda c, _: (c + x[0], c), x[0], None, length=0),
    "long scan over nothing": lambda x, i: lax.scan(
        lambda c, r: (c + r.sum(), r), x[0], jnp.zeros((5000, 0))
    ),
    "branches": lambda x, i: lax.cond(x[0] > 0, lambda y: y[:0], lambda y: y[1:1], x),
    "pad": lambda x, i: jnp.pad(x[:0], 2),
    "place of the largest": lambda x, i: jnp.argmax(jnp.zeros((0, 3)) + x[0], axis=1),
}

DRAWN: dict[str, Any] = {
    "uniform": lambda x, i: x + jax.random.uniform(jax.random.key(3)),
    "split": lambda x, i: x + jax.random.normal(jax.random.split(jax.random.key(3), 4)[2], (3,)),
    "old keys": lambda x, i: x + jax.random.normal(jax.random.PRNGKey(3), (3,)),
    "scan over keys": lambda x, i: lax.scan(
        lambda c, k: (c + jax.random.uniform(k), c), x, jax.random.split(jax.random.key(0), 5)
    ),
    "carried keys": lambda x, i: lax.scan(
        lambda c, _: ((c[0] + jax.random.uniform(c[1]), jax.random.split(c[1])[0]), None),
        (x, jax.random.key(0)),
        None,
        length=3,
    )[0][0],
    "key in a branch": lambda x, i: lax.cond(
        x[0] > 0, jax.random.uniform, lambda _: x[1], jax.random.key(2)
    ),
    "permutation": lambda x, i: jax.random.permutation(jax.random.key(2), x),
    "erf": lambda x, i: lax.erf(3 * x),
}

REFUSED: dict[str, tuple[Any, str]] = {
    "keys as results": (lambda x, i: jax.random.key(2), "return jax.random.key_data of them"),
    "complex": (lambda x, i: (x + 1j).real, "makes complex64 numbers"),
    "bfloat16": (lambda x, i: x.astype(jnp.bfloat16) * 2, "bfloat16"),
    "float16": (lambda x, i: (x.astype(jnp.float16) * 2).astype(jnp.float32), "float16"),
    "svd": (lambda x, i: jnp.linalg.svd(jnp.outer(x, x))[1], "svd"),
    "callback": (
        lambda x, i: jax.pure_callback(np.asarray, jax.ShapeDtypeStruct((3,), np.float32), x),
        "pure_callback",
    ),
}


@pytest.mark.parametrize("name", [*EMPTY, *DRAWN])
def test_arrays_without_numbers_and_known_random_keys_are_as_in_jax(name: str) -> None:
    function = {**EMPTY, **DRAWN}[name]
    got, want = lanes.vmap(function)(X, PLACES), jax.vmap(function)(X, PLACES)
    for ours, theirs in zip(jax.tree.leaves(got), jax.tree.leaves(want), strict=True):
        assert (ours.shape, ours.dtype) == (theirs.shape, theirs.dtype)
        np.testing.assert_allclose(ours, theirs, rtol=1e-5, atol=1e-6)  # float32 rounding


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_compiled_is_refused_by_name(name: str) -> None:
    function, named = REFUSED[name]
    with pytest.raises(lanes.CannotCompileError, match=named):
        lanes.vmap(function)(X, PLACES)


@pytest.mark.parametrize("function", [lax.erf, lax.erfc, lax.erf_inv])
def test_error_functions_of_float64_are_refused_by_name(function: Any) -> None:
    with jax.enable_x64(True):
        x = np.ones(3)
        np.testing.assert_array_equal(lanes.vmap(lambda x: x * 2.0)(x), 2 * x)
        named = rf"`{function.__name__}` of float64 numbers; use float32"
        with pytest.raises(lanes.CannotCompileError, match=named):
            lanes.vmap(function)(x)


def test_a_fault_of_a_handler_names_the_line_that_met_it(monkeypatch: Any) -> None:
    from mjxwalk.engines.lanes.frontend import tracing

    def faulty(*_: Any) -> Any:
        raise KeyError("absent")

    monkeypatch.setitem(tracing.HANDLERS, "sin", faulty)
    with pytest.raises(lanes.CannotCompileError, match=r"test_refusals.py.*KeyError"):
        lanes.vmap(lambda x: jnp.sin(x))(X[:, 0])
