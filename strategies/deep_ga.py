"""Uber's deep genetic algorithm: truncation selection and Gaussian mutation of fixed size alone.

Such, Madhavan, Conti, Lehman, Stanley & Clune (2017), "Deep neuroevolution: genetic algorithms are
a competitive alternative for training deep neural networks for reinforcement learning",
https://arxiv.org/abs/1712.06567, algorithm 1. The paper finds its elite by further trials of the
ten best; here the elite is the fittest told, and further trials are for the caller.
"""

import functools
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.strategies import checks, draws, generations, vectors
from mjxwalk.strategies.base import Genotype, Population, Strategy, Tree
from mjxwalk.strategies.generations import GAState
from mjxwalk.strategies.metrics import FitnessMetrics, summarise_fitness
from mjxwalk.strategies.operators import best_first

NUM_PARENTS = 20  # Such et al. (2017), table 2, of a population of 1,001
NUM_ELITES = 1  # algorithm 1


class _Settings(NamedTuple):
    """Checked arguments of `deep_ga`."""

    population_size: int
    sigma: Tree
    initial_sigma: Tree
    num_parents: int
    num_elites: int


def deep_ga(
    *,
    population_size: int,
    sigma: Tree,
    initial_sigma: Tree,
    num_parents: int = NUM_PARENTS,
    num_elites: int = NUM_ELITES,
) -> Strategy[GAState, FitnessMetrics]:
    """Returns the genetic algorithm of Such et al. (2017), algorithm 1.

    Args:
      population_size: genotypes in a generation.
      sigma: standard deviation of mutation, in units of the weights; one value, or a pytree prefix
        of the template.
      initial_sigma: standard deviation of generation 0 about the template, likewise.
      num_parents: best genotypes, of which every offspring is a mutated copy, all equally likely;
        the whole population at most.
      num_elites: best genotypes copied to the front of the next generation, best first.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_count("population_size", population_size, minimum=2)
    checks.check_numbers("sigma", sigma, minimum=0.0)
    checks.check_numbers("initial_sigma", initial_sigma, minimum=0.0)
    checks.check_count("num_parents", num_parents, minimum=1)
    checks.check_count("num_elites", num_elites, minimum=0, maximum=population_size - 1)
    settings = _Settings(
        population_size, sigma, initial_sigma, min(num_parents, population_size), num_elites
    )
    return Strategy(
        population_size=population_size,
        init=functools.partial(_init, settings),
        ask=generations.ask,
        tell=functools.partial(_tell, settings),
    )


def _init(settings: _Settings, key: PRNGKeyArray, template: Genotype) -> GAState:
    vectors.spread("sigma", settings.sigma, template)  # to refuse what does not fit
    start = vectors.flatten(template)
    initial_sigma = vectors.spread("initial_sigma", settings.initial_sigma, template)
    noise = vectors.standard_normals(key, settings.population_size, start)
    return generations.begin(
        vectors.unflatten_population(start + initial_sigma * noise, template), template
    )


def _tell(
    settings: _Settings,
    key: PRNGKeyArray,
    population: Population,
    fitness: Float[Array, " pop"],
    state: GAState,
) -> tuple[GAState, FitnessMetrics]:
    sigma = vectors.spread("sigma", settings.sigma, state.best_genotype)
    order = best_first(fitness)
    genotypes = vectors.flatten_population(population)
    num_offspring = settings.population_size - settings.num_elites
    picks, moves = draws.draw_words(key, num_offspring, [1, sigma.size])
    picked = jnp.floor(draws.uniforms(picks[:, 0]) * settings.num_parents).astype(jnp.int32)
    noise = draws.normals(moves).astype(sigma.dtype)
    offspring = genotypes[order[picked]] + sigma * noise
    elites = genotypes[order[: settings.num_elites]]
    new_state = generations.advance(
        state,
        vectors.unflatten_population(jnp.concatenate([elites, offspring]), state.best_genotype),
        vectors.unflatten(genotypes[order[0]], state.best_genotype),
        fitness[order[0]],
    )
    return new_state, FitnessMetrics(summarise_fitness(fitness))
