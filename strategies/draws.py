"""Random numbers of all kinds, cut out of one draw of random words.

Every draw from a key is a hash that XLA compiles anew, on a CPU for a tenth of a second whatever
its size, and that is more than all else in a generation. So a generation draws once.
"""

import math
from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, PRNGKeyArray, UInt32

from mjxwalk.strategies.base import FloatTree, Tree
from mjxwalk.strategies.threefry import random_words

WORD = 32  # bits


def draw_words(
    key: PRNGKeyArray, num_rows: int, sizes: Sequence[int]
) -> list[UInt32[Array, "row _"]]:
    """Returns independent words in parts of these many columns; uses up `key`."""
    words = random_words(key, (num_rows, sum(sizes)))
    return jnp.split(words, np.cumsum(sizes)[:-1].tolist(), axis=1)


def uniforms(words: UInt32[Array, "*shape"]) -> Float[Array, "*shape"]:
    """Returns numbers in [0, 1), one a word."""
    return _to_float(words >> 8) * 2.0**-24


def normals(words: UInt32[Array, "*shape"]) -> Float[Array, "*shape"]:
    """Returns standard normal numbers, one a word; their tails end at 5.3."""
    # The middles of 2^23 equal parts of (-1, 1), which float32 holds exactly.
    centred = _to_float(words >> 9 << 1 | 1) * 2.0**-23 - 1.0
    return math.sqrt(2.0) * jax.lax.erf_inv(centred)


def coins(words: UInt32[Array, "row words"], num: int) -> Bool[Array, "row {num}"]:
    """Returns fair booleans, one for each bit, the first `num` of each row."""
    bits = (words[..., None] >> jnp.arange(WORD, dtype=jnp.uint32)) & 1
    return bits.astype(bool).reshape(words.shape[0], -1)[:, :num]


def num_words(num_coins: int) -> int:
    """Returns how many words hold so many coins."""
    return math.ceil(num_coins / WORD)


def normal_like(key: PRNGKeyArray, tree: FloatTree) -> Tree:
    """Returns independent standard normal numbers in the shapes and dtypes of a pytree."""
    leaves, structure = jax.tree.flatten(tree)
    parts = draw_words(key, 1, [leaf.size for leaf in leaves])
    noise = [
        normals(part).reshape(leaf.shape).astype(leaf.dtype)
        for part, leaf in zip(parts, leaves, strict=True)
    ]
    return jax.tree.unflatten(structure, noise)


def _to_float(words: UInt32[Array, "*shape"]) -> Float[Array, "*shape"]:
    # By way of a signed number: the other conversion is no single instruction on most CPUs.
    return words.astype(jnp.int32).astype(jnp.float32)
