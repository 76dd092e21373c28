"""What genetic algorithms without masks or rates keep between generations, and how it moves on."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk.strategies.base import Genotype, Population


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


def begin(population: Population, template: Genotype) -> GAState:
    """Returns the state before generation 0 is evaluated."""
    return GAState(
        population=population,
        generation=jnp.zeros((), jnp.int32),
        best_genotype=template,
        best_fitness=jnp.full((), jnp.nan, float),
    )


def ask(key: PRNGKeyArray, state: GAState) -> tuple[Population, GAState]:
    """Returns the population that `begin` or `tell` has made already."""
    del key
    return state.population, state


def advance(
    state: GAState, population: Population, best: Genotype, best_fitness: Float[Array, ""]
) -> GAState:
    """Returns the state after a generation.

    Args:
      state: before it.
      population: to be evaluated next.
      best: fittest of the generation told.
      best_fitness: its fitness.
    """
    return GAState(
        population=population,
        generation=state.generation + 1,
        best_genotype=best,
        best_fitness=best_fitness.astype(state.best_fitness.dtype),
    )
