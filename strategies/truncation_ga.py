"""Genetic algorithm in which the better half replaces the worse, without crossover.

Reil & Massey (2001), "Facilitating controller evolution in morpho-functional machines - a bipedal
case study": the bottom half of a population is replaced by copies of the top half, mutated at a
rate of about one substitution a genotype. A substitution draws a weight anew between its bounds.
That the top half itself stays as it is, is ours: the paper does not say.
"""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.strategies import checks, draws
from mjxwalk.strategies.base import Genotype, ScalarLike, Strategy, Tree
from mjxwalk.strategies.bounds import check_bounds, draw_between, spread_bounds
from mjxwalk.strategies.generations import GAState, over_generations
from mjxwalk.strategies.metrics import FitnessMetrics
from mjxwalk.strategies.operators import uniform_mutation

SUBSTITUTIONS = 1.0  # a genotype, on average; Reil & Massey (2001)


class _Settings(NamedTuple):
    """Checked arguments of `truncation_ga`."""

    population_size: int
    lower: Tree
    upper: Tree
    substitutions: ScalarLike


def truncation_ga(
    *,
    population_size: int,
    lower: Tree,
    upper: Tree,
    substitutions: ScalarLike = SUBSTITUTIONS,
) -> Strategy[GAState, FitnessMetrics]:
    """Returns the genetic algorithm of Reil & Massey (2001); generation 0 is uniform in the bounds.

    Args:
      population_size: genotypes in a generation; of an odd number the middle one stays too.
      lower: smallest value of each weight; one value, or a pytree prefix of the template.
      upper: largest value, likewise.
      substitutions: weights of a copy that are drawn anew, on average.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_count("population_size", population_size, minimum=2)
    checks.check_numbers("substitutions", substitutions, minimum=0.0)
    check_bounds(lower, upper)
    settings = _Settings(population_size, lower, upper, substitutions)
    return over_generations(
        population_size=population_size,
        first=functools.partial(_first, settings),
        breed=functools.partial(_breed, settings),
    )


def _first(settings: _Settings, key: PRNGKeyArray, template: Genotype) -> Float[Array, "pop dim"]:
    lower, upper = spread_bounds(settings.lower, settings.upper, template)
    return draw_between(key, settings.population_size, lower, upper)


def _breed(
    settings: _Settings,
    key: PRNGKeyArray,
    genotypes: Float[Array, "pop dim"],
    template: Genotype,
) -> Float[Array, "pop dim"]:
    lower, upper = spread_bounds(settings.lower, settings.upper, template)
    num_copies = settings.population_size // 2
    which, values = draws.draw_words(key, num_copies, [lower.size, lower.size])
    uniform = jnp.stack([draws.uniforms(which), draws.uniforms(values)], axis=1)
    rate = jnp.asarray(settings.substitutions, lower.dtype) / lower.size
    mutate = jax.vmap(uniform_mutation, in_axes=(0, None, None, None, 0))
    copies = mutate(genotypes[:num_copies], lower, upper, rate, uniform)
    kept = genotypes[: settings.population_size - num_copies]
    return jnp.concatenate([kept, copies])
