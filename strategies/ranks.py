"""What a genotype's rank in its generation is worth; only the order of fitness counts.

Genotypes of equal fitness share the mean of what their ranks are worth, so that an arbitrary order
among them moves nothing: a generation that is all NaN, or all zero, leaves the search where it is.
"""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.strategies.operators import best_first


def centred_ranks(fitness: Float[Array, " pop"]) -> Float[Array, " pop"]:
    """Returns ranks scaled to [-0.5, 0.5], best highest; NaN ranks lowest.

    Salimans et al. (2017), "Evolution strategies as a scalable alternative to reinforcement
    learning", https://arxiv.org/abs/1703.03864, section 2: fitness shaping by ranks.
    """
    size = fitness.shape[0]
    return share_ties(fitness, np.linspace(0.5, -0.5, size) if size > 1 else np.zeros(size))


def nes_utilities(fitness: Float[Array, " pop"]) -> Float[Array, " pop"]:
    """Returns utilities that sum to zero, of which the worse half share the lowest.

    Wierstra et al. (2014), "Natural evolution strategies", JMLR 15:949-980,
    https://jmlr.org/papers/v15/wierstra14a.html, section 3.1.
    """
    size = fitness.shape[0]
    raw = np.maximum(0.0, np.log(size / 2 + 1) - np.log(np.arange(1, size + 1)))
    return share_ties(fitness, raw / raw.sum() - 1 / size)


def share_ties(
    fitness: Float[Array, " pop"], worth: Float[np.ndarray, " pop"]
) -> Float[Array, " pop"]:
    """Returns what each genotype is worth, those of equal fitness the mean of their ranks' worth.

    Args:
      fitness: higher is better; NaN is worst, and equal to NaN.
      worth: of each rank, best first.
    """
    size = fitness.shape[0]
    order = best_first(fitness)
    ordered = fitness[order]
    above, below = ordered[:-1], ordered[1:]
    differs = (above != below) & ~(jnp.isnan(above) & jnp.isnan(below))
    group = jnp.concatenate([jnp.zeros(1, jnp.int32), jnp.cumsum(differs, dtype=jnp.int32)])
    dtype = jnp.promote_types(fitness.dtype, jnp.float32)
    parts = jnp.stack([jnp.asarray(worth, dtype), jnp.ones(size, dtype)], axis=1)
    total, count = jax.ops.segment_sum(parts, group, size, indices_are_sorted=True).T
    return jnp.zeros(size, dtype).at[order].set((total / count)[group], unique_indices=True)


def finite(fitness: Float[Array, " pop"]) -> Float[Array, " pop"]:
    """Returns fitness for strategies that weigh by its size: none of it infinite or NaN.

    Infinity becomes the highest of the finite values, minus infinity and NaN the lowest; all are 0
    if none is finite.
    """
    is_finite = jnp.isfinite(fitness)
    highest = jnp.max(jnp.where(is_finite, fitness, -jnp.inf))
    lowest = jnp.min(jnp.where(is_finite, fitness, jnp.inf))
    filled = jnp.where(is_finite, fitness, jnp.where(fitness == jnp.inf, highest, lowest))
    return jnp.where(jnp.any(is_finite), filled, 0.0)
