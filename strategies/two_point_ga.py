"""Genetic algorithm with stochastic remainder selection, two-point crossover, uniform mutation.

As MATLAB's `ga` of the time ran with the options that a thesis of the Indian Institute of
Information Technology, Allahabad ("Designing CPG for Biped Locomotion Control using Nonlinear
Dynamical Theory", sections 4.3 and 5.1.1) names: 100 genotypes, two elites, `selectionremainder`,
`crossovertwopoint`, `mutationuniform`, and the scaling by rank that is MATLAB's default.

A generation: genotypes of rank n expect a share of 1 / sqrt(n) of all parents. Each is a parent as
often as the whole part of its expectation says; the places that are left are drawn with the parts
behind the point. The elites are copied, a fixed number of the others come from two parents each,
and the rest are mutated copies of one.

The thesis gives the crossover fraction as 0.99 in its text and as 0.999 in its table, and mutation
as a "fraction" of 0.001 beside a rate of 0.01 a gene. All are settings here. As the number of
offspring by crossover is rounded, 0.999 leaves none of 98 to mutation.
"""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks, draws, vectors
from mjxwalk.strategies.base import Genotype, Strategy, Tree
from mjxwalk.strategies.bounds import check_bounds, draw_between, spread_bounds
from mjxwalk.strategies.generations import GAState, over_generations
from mjxwalk.strategies.metrics import FitnessMetrics
from mjxwalk.strategies.operators import uniform_mutation

NUM_ELITES = 2  # section 4.3.3, step 4a
CROSSOVER_FRACTION = 0.99  # section 4.3.3, step 4b; its table has 0.999
MUTATION_RATE = 0.01  # section 4.3.3, step 4c, of each gene; its "fraction" is 0.001


class _Settings(NamedTuple):
    """Checked arguments of `two_point_ga`, with what follows from them."""

    population_size: int
    lower: Tree
    upper: Tree
    num_elites: int
    num_crossed: int
    mutation_rate: float
    keep_template: bool

    @property
    def num_mutated(self) -> int:
        """Offspring by mutation."""
        return self.population_size - self.num_elites - self.num_crossed

    @property
    def num_parents(self) -> int:
        """Places for parents; one genotype may fill several."""
        return 2 * self.num_crossed + self.num_mutated


def two_point_ga(
    *,
    population_size: int,
    lower: Tree,
    upper: Tree,
    num_elites: int = NUM_ELITES,
    crossover_fraction: float | int = CROSSOVER_FRACTION,
    mutation_rate: float | int = MUTATION_RATE,
    keep_template: bool = False,
) -> Strategy[GAState, FitnessMetrics]:
    """Returns the genetic algorithm of the thesis; generation 0 is uniform between the bounds.

    `lower` and `upper` are one value for all weights, or a pytree prefix of the template whose
    leaves broadcast to the template's.

    Args:
      population_size: genotypes in a generation.
      lower: smallest value of each weight, of generation 0 and of mutations.
      upper: largest value.
      num_elites: best genotypes copied to the front of the next generation, best first; no more
        than leaves one offspring.
      crossover_fraction: share of the others that come by crossover, rounded; the rest by mutation.
      mutation_rate: probability that a weight of a mutated copy is drawn anew.
      keep_template: whether genotype 0 of generation 0 is the template itself.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_count("population_size", population_size, minimum=2)
    checks.check_count("num_elites", num_elites, minimum=0)
    checks.check_numbers("crossover_fraction", crossover_fraction, minimum=0.0, maximum=1.0)
    checks.check_numbers("mutation_rate", mutation_rate, minimum=0.0, maximum=1.0)
    check_bounds(lower, upper)
    num_elites = min(num_elites, population_size - 1)
    settings = _Settings(
        population_size=population_size,
        lower=lower,
        upper=upper,
        num_elites=num_elites,
        num_crossed=round(crossover_fraction * (population_size - num_elites)),
        mutation_rate=float(mutation_rate),
        keep_template=keep_template,
    )
    return over_generations(
        population_size=population_size,
        first=functools.partial(_first, settings),
        breed=functools.partial(_breed, settings),
    )


def expected_parents(population_size: int, num_parents: int) -> Float[np.ndarray, " pop"]:
    """Returns how often each rank, best first, is expected among the parents.

    MATLAB's `fitscalingrank`: in proportion to 1 / sqrt(rank).
    """
    share = 1.0 / np.sqrt(np.arange(1, population_size + 1))
    return (num_parents / share.sum() * share).astype(np.float32)


def stochastic_remainder(
    expected: Float[Array, " pop"] | Float[np.ndarray, " pop"], draws: Float[Array, " parent"]
) -> Int[Array, " parent"]:
    """Returns indices of parents, as often as their expectations say.

    The whole part of an expectation is certain; what is left is drawn by roulette over the parts
    behind the point, with replacement.

    Args:
      expected: how often each is expected, in sum as many as there are draws.
      draws: uniform in [0, 1), one for each parent.
    """
    certain = jnp.floor(expected)
    slots = jnp.arange(draws.shape[0])
    ends = jnp.cumsum(certain)
    chosen = jnp.searchsorted(ends, slots.astype(ends.dtype), side="right")
    wheel = jnp.cumsum(expected - certain)
    drawn = jnp.searchsorted(wheel, draws.astype(wheel.dtype) * wheel[-1], side="right")
    last = jnp.asarray(expected).shape[0] - 1
    return jnp.minimum(jnp.where(slots < ends[-1], chosen, drawn), last).astype(jnp.int32)


def two_point_crossover(
    first: Float[Array, " dim"], second: Float[Array, " dim"], draws: Float[Array, "2"]
) -> Float[Array, " dim"]:
    """Returns the first parent with the weights between two points from the second.

    Points x <= y are from 1 to the number of weights: the child has weights 1 to x of the first
    parent, x + 1 to y of the second, and the rest of the first (section 4.3.3, step 4b).

    Args:
      first: parent.
      second: parent.
      draws: uniform in [0, 1), one for each point.
    """
    size = first.shape[0]
    points = jnp.sort(jnp.floor(draws * size)) + 1
    place = jnp.arange(size)
    return jnp.where((place >= points[0]) & (place < points[1]), second, first)


def _bounds(
    settings: _Settings, template: Genotype
) -> tuple[Float[Array, " dim"], Float[Array, " dim"]]:
    """Returns the bounds of each weight in the template's own precision, which breeding has too."""
    dtype = jnp.result_type(*jax.tree.leaves(template))
    lower, upper = spread_bounds(settings.lower, settings.upper, template)
    return lower.astype(dtype), upper.astype(dtype)


def _first(settings: _Settings, key: PRNGKeyArray, template: Genotype) -> Float[Array, "pop dim"]:
    drawn = draw_between(key, settings.population_size, *_bounds(settings, template))
    if settings.keep_template:
        drawn = drawn.at[0].set(vectors.flatten(template).astype(drawn.dtype))
    return drawn


def _breed(
    settings: _Settings,
    key: PRNGKeyArray,
    genotypes: Float[Array, "pop dim"],
    template: Genotype,
) -> Float[Array, "pop dim"]:
    lower, upper = _bounds(settings, template)
    genotypes = genotypes.astype(lower.dtype)
    size, num_crossed, num_mutated = lower.size, settings.num_crossed, settings.num_mutated
    num_parents = settings.num_parents
    parts = draws.draw_words(
        key, 1, [num_parents, num_parents, 2 * num_crossed, 2 * num_mutated * size]
    )
    choosing, shuffling, cutting, mutating = (draws.uniforms(part[0]) for part in parts)
    expected = expected_parents(settings.population_size, num_parents)
    places = stochastic_remainder(expected, choosing)[jnp.argsort(shuffling)]
    parents = genotypes[places]
    crossed = jax.vmap(two_point_crossover)(
        parents[:num_crossed],
        parents[num_crossed : 2 * num_crossed],
        cutting.reshape(num_crossed, 2),
    )
    mutated = jax.vmap(uniform_mutation, (0, None, None, None, 0))(
        parents[2 * num_crossed :],
        lower,
        upper,
        settings.mutation_rate,
        mutating.reshape(num_mutated, 2, size),
    )
    return jnp.concatenate([genotypes[: settings.num_elites], crossed, mutated])
