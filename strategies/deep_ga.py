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

from mjxwalk.strategies import checks, draws, vectors
from mjxwalk.strategies.base import Genotype, Strategy, Tree
from mjxwalk.strategies.generations import GAState, over_generations
from mjxwalk.strategies.metrics import FitnessMetrics

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
    return over_generations(
        population_size=population_size,
        first=functools.partial(_first, settings),
        breed=functools.partial(_breed, settings),
    )


def _first(settings: _Settings, key: PRNGKeyArray, template: Genotype) -> Float[Array, "pop dim"]:
    vectors.spread("sigma", settings.sigma, template)  # to refuse what does not fit
    start = vectors.flatten(template)
    initial_sigma = vectors.spread("initial_sigma", settings.initial_sigma, template)
    return start + initial_sigma * vectors.standard_normals(key, settings.population_size, start)


def _breed(
    settings: _Settings,
    key: PRNGKeyArray,
    genotypes: Float[Array, "pop dim"],
    template: Genotype,
) -> Float[Array, "pop dim"]:
    sigma = vectors.spread("sigma", settings.sigma, template)
    num_offspring = settings.population_size - settings.num_elites
    picks, moves = draws.draw_words(key, num_offspring, [1, sigma.size])
    picked = jnp.floor(draws.uniforms(picks[:, 0]) * settings.num_parents).astype(jnp.int32)
    noise = draws.normals(moves).astype(sigma.dtype)
    offspring = genotypes[picked] + sigma * noise
    return jnp.concatenate([genotypes[: settings.num_elites], offspring])
