"""Tests for random words, against JAX's own."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.strategies import threefry


@pytest.mark.parametrize("shape", [(), (1,), (7,), (3, 5), (2, 1, 4)])
def test_words_are_those_of_jax(shape: tuple[int, ...]):
    for seed in (0, 1, 2**31 - 1):
        key = jax.random.key(seed)
        np.testing.assert_array_equal(
            threefry.random_words(key, shape), jax.random.bits(key, shape, jnp.uint32)
        )


def test_words_under_vmap_are_those_of_jax():
    keys = jax.random.split(jax.random.key(3), 4)
    got = jax.vmap(lambda key: threefry.random_words(key, (2, 3)))(keys)
    expected = jax.vmap(lambda key: jax.random.bits(key, (2, 3), jnp.uint32))(keys)
    np.testing.assert_array_equal(got, expected)


@pytest.mark.parametrize(
    "make", [jax.random.PRNGKey, lambda seed: jax.random.key(seed, impl="rbg")]
)
def test_keys_of_other_kinds_give_the_words_of_jax(make: object):
    key = make(5)  # pyright: ignore[reportCallIssue, reportUnknownVariableType]
    np.testing.assert_array_equal(
        threefry.random_words(key, (4, 3)), jax.random.bits(key, (4, 3), jnp.uint32)
    )


def test_a_known_answer_of_the_papers_own_code():
    # The third vector of `threefry2x32 20` in kat_vectors of Random123, by the paper's authors.
    left, right = threefry.hash_words(
        *(jnp.uint32(word) for word in (0x13198A2E, 0x03707344, 0x243F6A88, 0x85A308D3))
    )
    assert (int(left), int(right)) == (0xC4923A9C, 0x483DF7A0)
