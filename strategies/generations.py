"""Genetic algorithms whose genotypes are vectors without masks or rates of their own."""

from collections.abc import Callable
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk.strategies import vectors
from mjxwalk.strategies.base import Genotype, Population, Strategy
from mjxwalk.strategies.metrics import FitnessMetrics, summarise_fitness
from mjxwalk.strategies.operators import best_first


class GAState(NamedTuple):
    """State between generations; all that `ask` gives out next is in it.

    Attributes:
      population: genotypes of the generation to be evaluated next.
      generation: number of that generation, 0 before the first `tell`.
      best_genotype: fittest of the generation told last; the template before the first.
      best_fitness: its fitness; NaN before the first `tell` or if all of that generation was NaN.
    """

    population: Population
    generation: Int[Array, ""]
    best_genotype: Genotype
    best_fitness: Float[Array, ""]


def over_generations(
    *,
    population_size: int,
    first: Callable[[PRNGKeyArray, Genotype], Float[Array, "pop dim"]],
    breed: Callable[[PRNGKeyArray, Float[Array, "pop dim"], Genotype], Float[Array, "pop dim"]],
) -> Strategy[GAState, FitnessMetrics]:
    """Returns the genetic algorithm that makes each generation of the one before.

    Args:
      population_size: genotypes in a generation.
      first: draws generation 0 about a template, see `vectors.flatten`; uses up its key.
      breed: makes a generation of the last, whose genotypes are given best first, in the shapes of
        a genotype; uses up its key.
    """

    def init(key: PRNGKeyArray, template: Genotype) -> GAState:
        return GAState(
            population=vectors.unflatten_population(first(key, template), template),
            generation=jnp.zeros((), jnp.int32),
            best_genotype=template,
            best_fitness=jnp.full((), jnp.nan, float),
        )

    def ask(key: PRNGKeyArray, state: GAState) -> tuple[Population, GAState]:
        del key
        return state.population, state

    def tell(
        key: PRNGKeyArray, population: Population, fitness: Float[Array, " pop"], state: GAState
    ) -> tuple[GAState, FitnessMetrics]:
        order = best_first(fitness)
        genotypes = vectors.flatten_population(population)[order]
        bred = breed(key, genotypes, state.best_genotype)
        new_state = GAState(
            population=vectors.unflatten_population(bred, state.best_genotype),
            generation=state.generation + 1,
            best_genotype=vectors.unflatten(genotypes[0], state.best_genotype),
            best_fitness=fitness[order[0]].astype(state.best_fitness.dtype),
        )
        return new_state, FitnessMetrics(summarise_fitness(fitness))

    return Strategy(population_size=population_size, init=init, ask=ask, tell=tell)
