"""Each walker draws from its own key what JAX draws from it, bit for bit."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import lax, random

from mjxwalk.engines import lanes
from mjxwalk.engines.lanes.frontend.primitives import control_flow

NUMBER = np.arange(37, dtype=np.int32)
KEYS = random.split(random.key(3), 37)

EXACT: dict[str, Any] = {
    "uniform": lambda k, i: random.uniform(k, (3,)),
    "uniform in a range": lambda k, i: random.uniform(k, (2,), minval=-3.0, maxval=2.0),
    "bernoulli": lambda k, i: random.bernoulli(k, 0.3, (4,)),
    "integers": lambda k, i: random.randint(k, (3,), -5, 17),
    "bits": lambda k, i: (random.bits(k, (3,)), random.bits(k, (3,), "uint8")),
    "choice": lambda k, i: random.choice(k, jnp.arange(10.0), (3,)),
    "choice of each once": lambda k, i: random.choice(k, 5, (3,), replace=False),
    "weighted choice": lambda k, i: random.choice(k, 3, (2,), p=jnp.array([0.2, 0.3, 0.5])),
    "permutation": lambda k, i: random.permutation(k, 6),
    "split": lambda k, i: random.key_data(random.split(k, 3)),
    "fold in": lambda k, i: random.uniform(random.fold_in(k, i), (2,)),
    "fold into a known key": lambda k, i: random.uniform(random.fold_in(random.key(0), i)),
    "seed": lambda k, i: random.uniform(random.key(i)),
    "one key of many": lambda k, i: random.uniform(random.split(k, 4)[i % 4]),
    "one of known keys": lambda k, i: random.uniform(random.split(random.key(1), 40)[i]),
    "a key for each": lambda k, i: jax.vmap(random.uniform)(random.split(k, 3)),
    "loop": lambda k, i: lax.while_loop(
        lambda c: c[1] < i,
        lambda c: (random.fold_in(c[0], c[1]), c[1] + 1, c[2] + random.uniform(c[0])),
        (k, 0, 0.0),
    )[2],
    "scan over keys": lambda k, i: lax.scan(
        lambda c, each: (c + random.uniform(each), random.key_data(each)), 0.0, random.split(k, 3)
    ),
    "long scan that keeps keys": lambda k, i: random.key_data(
        lax.scan(lambda c, n: (random.fold_in(c, n), c), k, jnp.arange(40))[1][i]
    ),
    "branches": lambda k, i: random.uniform(
        lax.cond(i > 5, lambda k: random.split(k)[0], lambda k: k, k)
    ),
}
TYPED: dict[str, Any] = {
    "switch": lambda k, i: random.uniform(
        lax.switch(i % 3, [lambda k: k, lambda k: random.fold_in(k, 7), lambda k: random.key(9)], k)
    ),
    "where": lambda k, i: random.uniform(jnp.where(i > 4, k, random.key(0))),
    "written": lambda k, i: jax.vmap(random.uniform)(
        random.split(k, 3).at[i % 3].set(random.key(4))
    ),
    "joined": lambda k, i: jax.vmap(random.uniform)(jnp.stack([k, random.key(5), k])),
    "clone": lambda k, i: random.uniform(random.clone(k)),
}


def agree(function: Any, keys: Any, rtol: float = 0.0, atol: float = 0.0) -> None:
    """Asserts that lanes draws what JAX does."""
    got, want = lanes.vmap(function)(keys, NUMBER), jax.jit(jax.vmap(function))(keys, NUMBER)
    for ours, theirs in zip(jax.tree.leaves(got), jax.tree.leaves(want), strict=True):
        assert (ours.shape, ours.dtype) == (theirs.shape, theirs.dtype)
        np.testing.assert_allclose(ours, theirs, rtol, atol)


@pytest.mark.parametrize("name", [*EXACT, *TYPED])
def test_keys_of_their_own_type_draw_the_bits_of_jax(name: str) -> None:
    agree((EXACT | TYPED)[name], KEYS)


@pytest.mark.parametrize("name", EXACT)
def test_keys_as_plain_words_draw_the_bits_of_jax(name: str) -> None:
    agree(EXACT[name], random.key_data(KEYS))


@pytest.mark.parametrize("name", ["branches", "switch"])
def test_branches_that_are_passed_over_take_and_give_keys(name: str, monkeypatch: Any) -> None:
    monkeypatch.setattr(control_flow, "WORTH_SKIPPING", 0)
    agree((EXACT | TYPED)[name], KEYS)


def test_the_older_layout_of_counters_draws_the_bits_of_jax() -> None:
    with jax.threefry_partitionable(False):
        agree(lambda k, i: (random.uniform(k, (3,)), random.bits(k, (3,), "uint16")), KEYS)
        agree(lambda k, i: random.uniform(random.split(k, 3)[1]), KEYS)


def test_draws_of_64_bits_are_those_of_jax() -> None:
    with jax.enable_x64(True):
        agree(lambda k, i: random.uniform(k, (3,), "float64"), KEYS)


@pytest.mark.parametrize("draw", [random.normal, random.exponential, random.gumbel])
def test_functions_of_what_is_drawn_agree_to_rounding(draw: Any) -> None:
    """XLA's inverse of erf is 60 roundings off near its ends, so normal numbers are 3e-6 apart."""
    agree(lambda k, i: draw(k, (5,)), KEYS, rtol=4e-6, atol=1e-6)


def test_keys_that_all_walkers_share_are_an_argument() -> None:
    def function(key: Any, number: Any) -> Any:
        return random.uniform(random.fold_in(key, number))

    got = lanes.vmap(function, (None, 0))(random.key(8), NUMBER)
    np.testing.assert_array_equal(got, jax.vmap(function, (None, 0))(random.key(8), NUMBER))


def test_a_matrix_of_keys_is_mapped_along_any_axis() -> None:
    keys = random.split(random.key(1), (2, 37))
    for axis in (1, -1):
        mapped = lanes.vmap(lambda k: jax.vmap(random.uniform)(k), axis)
        np.testing.assert_array_equal(mapped(keys), jax.vmap(jax.vmap(random.uniform), axis)(keys))


def test_other_generators_are_refused_by_name() -> None:
    keys = random.split(random.key(0, impl="rbg"), 5)
    with pytest.raises(lanes.CannotCompileError, match=r"random_bits.*keys of the kind rbg"):
        lanes.vmap(lambda k: random.uniform(k))(keys)
