"""A genetic algorithm and then a pattern search from the best that it found.

MATLAB's `ga` with a `HybridFcn` of `patternsearch`, as a thesis of the Indian Institute of
Information Technology, Allahabad ("Designing CPG for Biped Locomotion Control using Nonlinear
Dynamical Theory", section 5.1.1) uses it; `two_point_ga` and `pattern_search` are the two.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks
from mjxwalk.strategies.base import Genotype, Population, Strategy, Tree
from mjxwalk.strategies.generations import GAState
from mjxwalk.strategies.metrics import FitnessMetrics, summarise_fitness
from mjxwalk.strategies.pattern_search import (
    CONTRACTION,
    EXPANSION,
    INITIAL_MESH,
    SMALLEST_MESH,
    PatternSearchMetrics,
    PatternSearchState,
    pattern_search,
)
from mjxwalk.strategies.two_point_ga import (
    CROSSOVER_FRACTION,
    MUTATION_RATE,
    NUM_ELITES,
    two_point_ga,
)


class HybridGAState(NamedTuple):
    """State between generations.

    Attributes:
      breeding: of the genetic algorithm.
      searching: of the pattern search, which waits until the other is done.
      generation: told so far.
      finished: whether the pattern search has come to its end.
    """

    breeding: GAState
    searching: PatternSearchState
    generation: Int[Array, ""]
    finished: Bool[Array, ""]


def hybrid_ga(
    *,
    population_size: int,
    lower: Tree,
    upper: Tree,
    breeding_generations: int,
    num_elites: int = NUM_ELITES,
    crossover_fraction: float | int = CROSSOVER_FRACTION,
    mutation_rate: float | int = MUTATION_RATE,
    keep_template: bool = False,
    scale: Tree = 1.0,
    initial_mesh: float | int = INITIAL_MESH,
    expansion: float | int = EXPANSION,
    contraction: float | int = CONTRACTION,
    smallest_mesh: float | int = SMALLEST_MESH,
    bounded: bool = True,
) -> Strategy[HybridGAState, PatternSearchMetrics]:
    """Returns the genetic algorithm that hands its best to a pattern search.

    Args:
      population_size: genotypes in a generation, of both.
      lower: as of `two_point_ga`.
      upper: as of `two_point_ga`.
      breeding_generations: of the genetic algorithm; the rest are the pattern search's.
      num_elites: as of `two_point_ga`.
      crossover_fraction: as of `two_point_ga`.
      mutation_rate: as of `two_point_ga`.
      keep_template: as of `two_point_ga`.
      scale: as of `pattern_search`.
      initial_mesh: as of `pattern_search`.
      expansion: as of `pattern_search`.
      contraction: as of `pattern_search`.
      smallest_mesh: as of `pattern_search`.
      bounded: whether the bounds hold for the pattern search too.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_count("breeding_generations", breeding_generations, minimum=1)
    breeder = two_point_ga(
        population_size=population_size,
        lower=lower,
        upper=upper,
        num_elites=num_elites,
        crossover_fraction=crossover_fraction,
        mutation_rate=mutation_rate,
        keep_template=keep_template,
    )
    searcher = pattern_search(
        population_size=population_size,
        scale=scale,
        initial_mesh=initial_mesh,
        expansion=expansion,
        contraction=contraction,
        smallest_mesh=smallest_mesh,
        lower=lower if bounded else None,
        upper=upper if bounded else None,
    )
    return in_turn(breeder, searcher, after=breeding_generations)


def in_turn(
    breeder: Strategy[GAState, FitnessMetrics],
    searcher: Strategy[PatternSearchState, PatternSearchMetrics],
    *,
    after: int,
) -> Strategy[HybridGAState, PatternSearchMetrics]:
    """Returns the strategy that is the first for some generations, then the second.

    Args:
      breeder: a `two_point_ga`.
      searcher: a `pattern_search` of the same population size.
      after: generations of the first.
    """

    def init(key: PRNGKeyArray, template: Genotype) -> HybridGAState:
        key_breeding, key_searching = jax.random.split(key)
        return HybridGAState(
            breeding=breeder.init(key_breeding, template),
            searching=searcher.init(key_searching, template),
            generation=jnp.zeros((), jnp.int32),
            finished=jnp.zeros((), bool),
        )

    def ask(key: PRNGKeyArray, state: HybridGAState) -> tuple[Population, HybridGAState]:
        # The other strategy's population stands in its state, and needs no key.
        polled, _ = searcher.ask(key, state.searching)
        is_searching = state.generation >= after
        return jax.tree.map(
            lambda a, b: jnp.where(is_searching, a, b), polled, state.breeding.population
        ), state

    def tell(
        key: PRNGKeyArray,
        population: Population,
        fitness: Float[Array, " pop"],
        state: HybridGAState,
    ) -> tuple[HybridGAState, PatternSearchMetrics]:

        def breed(key: PRNGKeyArray) -> HybridGAState:
            breeding, _ = breeder.tell(key, population, fitness, state.breeding)
            searching = state.searching._replace(centre=breeding.best_genotype)
            return state._replace(breeding=breeding, searching=searching)

        def search(key: PRNGKeyArray) -> HybridGAState:
            searching, _ = searcher.tell(key, population, fitness, state.searching)
            return state._replace(searching=searching, finished=searching.finished)

        after_told = jax.lax.cond(state.generation >= after, search, breed, key)
        metrics = PatternSearchMetrics(summarise_fitness(fitness), mesh=state.searching.mesh)
        return after_told._replace(generation=state.generation + 1), metrics

    return Strategy(population_size=breeder.population_size, init=init, ask=ask, tell=tell)
