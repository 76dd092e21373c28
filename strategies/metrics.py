"""What strategies tell of a generation; all of them have its summary of fitness, as `fitness`."""

from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from mjxwalk.strategies.edge import as_floats


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


def of_fitness(metrics: Any, name: str) -> Any:
    """Returns a figure of the summary of fitness, for metrics that have it at hand.

    Raises:
      AttributeError: the summary has no such figure.
    """
    if name not in FitnessSummary._fields:
        raise AttributeError(f"{type(metrics).__name__!r} object has no attribute {name!r}")
    return getattr(metrics.fitness, name)


class FitnessMetrics(NamedTuple):
    """Scalars about the generation told by a strategy that has none of its own to add.

    Attributes:
      fitness: summary of the generation's fitness.
    """

    fitness: FitnessSummary
    __getattr__ = of_fitness


class SearchMetrics(NamedTuple):
    """Scalars about the generation told by a strategy that searches with one distribution.

    Attributes:
      fitness: summary of the generation's fitness.
      sigma: standard deviation of a weight in that generation, root mean square over all weights.
    """

    fitness: FitnessSummary
    sigma: Float[Array, ""]
    __getattr__ = of_fitness


def measure_search(fitness: Float[Array, " pop"], sigma: Float[Array, "*dim"]) -> SearchMetrics:
    """Returns the metrics of a generation drawn with these standard deviations."""
    # Scaled, so that squares of the smallest and largest do not leave float32.
    largest = jnp.max(sigma)
    rms = largest * jnp.sqrt(jnp.mean((sigma / largest) ** 2))
    return SearchMetrics(summarise_fitness(fitness), sigma=rms)


def summarise_fitness(fitness: Float[Array, " pop"]) -> FitnessSummary:
    """Returns best, mean and median of the finite values, and the number of NaN."""
    fitness = as_floats("fitness", fitness)
    is_finite, is_nan = jnp.isfinite(fitness), jnp.isnan(fitness)
    # One sort and one sum serve all figures, as each more takes XLA longer than it runs.
    parts = jnp.stack([is_finite, is_nan, jnp.where(is_finite, fitness, 0.0)])
    num_finite, num_nan, total = jnp.sum(parts, axis=1)
    # NaN sorts last, and stands at all of these places if nothing is finite.
    ascending = jnp.sort(jnp.where(is_finite, fitness, jnp.nan))
    last = num_finite.astype(jnp.int32) - 1
    best, lower, upper = ascending[jnp.stack([last, last // 2, (last + 1) // 2])]
    return FitnessSummary(
        best_fitness=best,
        mean_fitness=total / num_finite,
        median_fitness=lower / 2 + upper / 2,
        num_nan=num_nan.astype(jnp.int32),
    )
