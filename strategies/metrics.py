"""Summary of a generation's fitness, the same for every strategy."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int


class FitnessSummary(NamedTuple):
    """Scalars over the finite fitness of one generation; NaN where none is finite.

    Attributes:
      best_fitness: highest.
      mean_fitness: mean.
      median_fitness: median.
      num_nan: genotypes whose fitness is NaN, as when a rollout breaks down.
    """

    best_fitness: Float[Array, ""]
    mean_fitness: Float[Array, ""]
    median_fitness: Float[Array, ""]
    num_nan: Int[Array, ""]


def summarise_fitness(fitness: Float[Array, " pop"]) -> FitnessSummary:
    """Returns best, mean and median of the finite values, and the number of NaN."""
    finite = jnp.where(jnp.isfinite(fitness), fitness, jnp.nan)
    return FitnessSummary(
        best_fitness=jnp.nanmax(finite),
        mean_fitness=jnp.nanmean(finite),
        median_fitness=jnp.nanmedian(finite),
        num_nan=jnp.sum(jnp.isnan(fitness)),
    )
