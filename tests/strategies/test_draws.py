"""Tests for numbers cut out of random words, against numpy, scipy and words chosen by hand."""

import jax
import jax.numpy as jnp
import numpy as np
from scipy import stats

from mjxwalk.strategies import draws

LOWEST, HIGHEST = 0, 2**32 - 1


def _words(key: int, *shape: int) -> jax.Array:
    return jax.random.bits(jax.random.key(key), shape, jnp.uint32)


def test_uniforms_are_a_words_share_of_all_and_stay_below_one():
    words = jnp.array([LOWEST, 2**31, 3 * 2**30, HIGHEST], jnp.uint32)
    np.testing.assert_array_equal(draws.uniforms(words), [0.0, 0.5, 0.75, 1 - 2.0**-24])


def test_normals_are_the_quantiles_of_their_words():
    words = np.array([LOWEST, 2**29, 2**31 - 1, 2**31, 3 * 2**30, HIGHEST], np.uint32)
    middles = ((words >> 9) + 0.5) / 2.0**23
    # The inverse error function in float32 is good to a few units in the last place.
    np.testing.assert_allclose(
        draws.normals(jnp.asarray(words)), stats.norm.ppf(middles), rtol=2e-5, atol=1e-7
    )


def test_normals_are_symmetric():
    words = _words(0, 1_000)
    np.testing.assert_array_equal(draws.normals(~words), -draws.normals(words))


def test_random_normals_are_normal_and_those_of_neighbours_independent():
    values = np.asarray(draws.normals(_words(1, 100, 200)))
    # By chance alone the distribution is as bad as that once in a thousand keys.
    assert stats.kstest(values.ravel(), "norm").pvalue > 1e-3
    # 20,000 pairs: standard error 0.007; five.
    assert abs(np.corrcoef(values[:, :-1].ravel(), values[:, 1:].ravel())[0, 1]) < 0.035


def test_coins_are_the_bits_of_their_words():
    words = np.array([[0b1011, 1], [HIGHEST, 0]], np.uint32)
    coins = np.asarray(draws.coins(jnp.asarray(words), 34))
    expected = np.unpackbits(words.view(np.uint8), axis=1, bitorder="little")[:, :34]
    np.testing.assert_array_equal(coins, expected)
    assert [draws.num_words(num) for num in (1, 32, 33)] == [1, 1, 2]


def test_parts_of_a_draw_are_different_words():
    first, second = draws.draw_words(jax.random.key(0), 50, [30, 20])
    assert (first.shape, second.shape) == ((50, 30), (50, 20))
    both = np.concatenate([first, second], axis=1)
    # 2,500 of 2^32 words: a pair of them is the same with a chance of 1e-3, here with none.
    assert np.unique(both).size == both.size


def test_normal_numbers_are_standard_and_independent_between_leaves():
    tree = {"a": jnp.zeros((100, 100)), "b": [jnp.zeros(10_000)]}
    noise = draws.normal_like(jax.random.key(0), tree)
    values = np.stack([np.ravel(leaf) for leaf in jax.tree.leaves(noise)])
    # Standard errors over 10,000 draws are 0.01 (mean, covariance) and 0.014 (variance); five.
    np.testing.assert_allclose(values.mean(axis=1), 0, atol=0.05)
    np.testing.assert_allclose(np.cov(values), np.eye(2), atol=0.07)


def test_narrow_weights_get_the_tails_of_wide_ones():
    noise = draws.normal_like(jax.random.key(0), jnp.zeros(20_000, jnp.bfloat16))
    assert noise.dtype == jnp.bfloat16
    # 20,000 normal numbers reach 3.5 but with a chance of 1e-4; bfloat16's own stop before 3.
    assert jnp.max(jnp.abs(noise)) > 3.5
