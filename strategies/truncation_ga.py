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

from mjxwalk.strategies import checks, draws, generations, vectors
from mjxwalk.strategies.base import Genotype, Population, ScalarLike, Strategy, Tree
from mjxwalk.strategies.generations import GAState
from mjxwalk.strategies.metrics import FitnessMetrics, summarise_fitness
from mjxwalk.strategies.operators import best_first
from mjxwalk.strategies.two_point_ga import check_bounds, uniform_mutation

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
    return Strategy(
        population_size=population_size,
        init=functools.partial(_init, settings),
        ask=generations.ask,
        tell=functools.partial(_tell, settings),
    )


def _init(settings: _Settings, key: PRNGKeyArray, template: Genotype) -> GAState:
    lower, upper = _bounds(settings, template)
    (words,) = draws.draw_words(key, settings.population_size, [lower.size])
    genotypes = lower + (upper - lower) * draws.uniforms(words).astype(lower.dtype)
    return generations.begin(vectors.unflatten_population(genotypes, template), template)


def _tell(
    settings: _Settings,
    key: PRNGKeyArray,
    population: Population,
    fitness: Float[Array, " pop"],
    state: GAState,
) -> tuple[GAState, FitnessMetrics]:
    lower, upper = _bounds(settings, state.best_genotype)
    order = best_first(fitness)
    genotypes = vectors.flatten_population(population)[order]
    num_copies = settings.population_size // 2
    which, values = draws.draw_words(key, num_copies, [lower.size, lower.size])
    uniform = jnp.stack([draws.uniforms(which), draws.uniforms(values)], axis=1)
    rate = jnp.asarray(settings.substitutions, lower.dtype) / lower.size
    mutate = jax.vmap(uniform_mutation, in_axes=(0, None, None, None, 0))
    copies = mutate(genotypes[:num_copies], lower, upper, rate, uniform)
    kept = genotypes[: settings.population_size - num_copies]
    new_state = generations.advance(
        state,
        vectors.unflatten_population(jnp.concatenate([kept, copies]), state.best_genotype),
        vectors.unflatten(genotypes[0], state.best_genotype),
        fitness[order[0]],
    )
    return new_state, FitnessMetrics(summarise_fitness(fitness))


def _bounds(
    settings: _Settings, template: Genotype
) -> tuple[Float[Array, " dim"], Float[Array, " dim"]]:
    return (
        vectors.spread("lower", settings.lower, template),
        vectors.spread("upper", settings.upper, template),
    )
