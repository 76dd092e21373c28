"""Genetic algorithm with truncation selection, an elite and self-adapted mutation.

Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient 2D and 3D bipedal
walking over rough terrain", Adaptive Behavior 21(1), doi 10.1177/1059712312462904, section 2.7.

A generation, as the paper states it: rank by fitness; the top fifth are parents; the best is
copied; every other offspring is, with probability 1/4, a discrete crossover of two parents, with
1/4 a mutated copy of one, and with 1/2 a crossover that is then mutated. Discrete crossover takes
each weight from either parent. Mutation adds N(0, sigma) to all weights. Learning rates, one for
each controller network, evolve beside the weights and change the size of mutations. Every genotype
is evaluated anew each generation, the elite too, because each generation has its own terrain; here
that is for the caller of `tell` to decide. `self_adaptive_breeding` makes the offspring.

The rule for the learning rates is lost from the text that is left, and much around it is unsaid.
Ours:
- rates start at 1, step log-normally when an individual is mutated, then scale that same mutation;
- rates recombine as weights do, each from either parent;
- the two parents of a crossover differ, since one with itself would only copy;
- an individual has a mask (the paper prunes links one individual at a time), and each link comes
  with its weight from the same parent.
"""

import functools
import math
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float, Int, PRNGKeyArray, Shaped

from mjxwalk.strategies import checks, draws, operators, prefixes
from mjxwalk.strategies.base import (
    Genotype,
    Mask,
    Masks,
    Population,
    ScalarLike,
    Strategy,
    Tree,
)
from mjxwalk.strategies.metrics import FitnessSummary, of_fitness, summarise_fitness
from mjxwalk.strategies.operators import Individual
from mjxwalk.strategies.self_adaptive_breeding import Breeding, breed, number_apart

PARENT_FRACTION = 0.2  # Solomon et al. (2013), section 2.7.3, selection
NUM_ELITES = 1  # section 2.7.3 in 2D; the paper's 3D runs have none
CROSSOVER_FRACTION = 0.25  # section 2.7.3; what is neither of these two shares is both in turn
MUTATION_FRACTION = 0.25  # section 2.7.3
INITIAL_LEARNING_RATE = 1.0  # ours: the rule is lost; 1 starts with the paper's own sigma
MINIMUM_LEARNING_RATE = 0.01  # ours: a rate near 0 would freeze its network for good


class SelfAdaptiveGAState(NamedTuple):
    """State between generations; all that `ask` gives out next is in it.

    Attributes:
      population: genotypes of the generation to be evaluated next.
      mask: True where an individual of that generation has the link.
      learning_rates: scale of mutation of each individual's groups.
      generation: number of that generation, 0 before the first `tell`.
      best_genotype: fittest of the generation told last, since fitness may be drawn anew each time;
        the template before the first.
      best_mask: links of `best_genotype`.
      best_fitness: its fitness; NaN before the first `tell` or if all of that generation was NaN.
    """

    population: Population
    mask: Masks
    learning_rates: Float[Array, "pop groups"]
    generation: Int[Array, ""]
    best_genotype: Genotype
    best_mask: Mask
    best_fitness: Float[Array, ""]


class SelfAdaptiveGAMetrics(NamedTuple):
    """Scalars about the generation told.

    Attributes:
      fitness: summary of the generation's fitness.
      mean_learning_rate: over all individuals and groups.
    """

    fitness: FitnessSummary
    mean_learning_rate: Float[Array, ""]
    __getattr__ = of_fitness


class _Settings(NamedTuple):
    """Checked arguments of `self_adaptive_ga`, with what follows from them."""

    population_size: int
    num_parents: int
    num_elites: int
    num_groups: int
    keep_template: bool
    sigma: Tree
    initial_sigma: Tree
    groups: Tree
    links: Tree
    mask: Tree
    crossover_fraction: ScalarLike
    mutation_fraction: ScalarLike
    learning_rate_tau: ScalarLike | None
    minimum_learning_rate: ScalarLike


def self_adaptive_ga(
    *,
    population_size: int,
    sigma: Tree,
    initial_sigma: Tree,
    parent_fraction: float | int = PARENT_FRACTION,
    num_elites: int = NUM_ELITES,
    crossover_fraction: ScalarLike = CROSSOVER_FRACTION,
    mutation_fraction: ScalarLike = MUTATION_FRACTION,
    learning_rate_tau: ScalarLike | None = None,
    minimum_learning_rate: ScalarLike = MINIMUM_LEARNING_RATE,
    groups: Tree = None,
    links: Tree = -1,
    mask: Tree = None,
    keep_template: bool = False,
) -> Strategy[SelfAdaptiveGAState, SelfAdaptiveGAMetrics]:
    """Returns the self-adaptive genetic algorithm of Solomon et al. (2013), section 2.7.

    `sigma`, `initial_sigma`, `groups`, `links` and `mask` are one value for all weights, or a
    pytree prefix of the template whose leaves broadcast to the template's.

    Args:
      population_size: genotypes in a generation.
      sigma: standard deviation of mutation at a learning rate of 1, in units of the weights.
      initial_sigma: standard deviation of generation 0 about the template.
      parent_fraction: share of a generation that are parents, rounded; one at least.
      num_elites: best genotypes copied to the front of the next generation, best first.
      crossover_fraction: probability that an offspring is made by crossover alone.
      mutation_fraction: probability that it is made by mutation alone; else by both.
      learning_rate_tau: standard deviation of a step of a learning rate's logarithm; None for
        1 / sqrt(2 n) with n weights.
      minimum_learning_rate: smallest learning rate.
      groups: index of the learning rate that scales each weight, one for each controller network,
        numbered from 0 without gaps; None for one rate.
      links: number of the link that each weight belongs to: all weights of a link are from the same
        parent. A weight of a negative number is a link by itself.
      mask: weights that every individual starts with; None for all.
      keep_template: whether genotype 0 of generation 0 is the template itself.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_count("population_size", population_size, minimum=2)
    checks.check_numbers("parent_fraction", parent_fraction, above=0.0, maximum=1.0)
    groups = 0 if groups is None else groups
    settings = _Settings(
        population_size=population_size,
        num_parents=max(1, round(parent_fraction * population_size)),
        num_elites=num_elites,
        num_groups=prefixes.count_groups(groups),
        keep_template=keep_template,
        sigma=sigma,
        initial_sigma=initial_sigma,
        groups=groups,
        links=links,
        mask=True if mask is None else mask,
        crossover_fraction=crossover_fraction,
        mutation_fraction=mutation_fraction,
        learning_rate_tau=learning_rate_tau,
        minimum_learning_rate=minimum_learning_rate,
    )
    _check(settings)
    return Strategy(
        population_size=population_size,
        init=functools.partial(_init, settings),
        ask=_ask,
        tell=functools.partial(_tell, settings),
    )


def _init(settings: _Settings, key: PRNGKeyArray, template: Genotype) -> SelfAdaptiveGAState:
    _breeding(settings, template)  # to refuse what does not fit before anything is evaluated
    initial_sigma = prefixes.match_template("initial_sigma", settings.initial_sigma, template)
    mask = prefixes.match_template("mask", settings.mask, template, bool)
    start = Individual(operators.remove_masked(template, mask), mask)

    everyone = jax.tree.map(
        lambda leaf: jnp.broadcast_to(leaf, (settings.population_size, *leaf.shape)), start
    )
    noise = draws.normal_like(key, everyone.genotype)
    population, masks = operators.gaussian_mutation(everyone, initial_sigma, noise)
    if settings.keep_template:
        population = jax.tree.map(lambda p, w: p.at[0].set(w), population, start.genotype)
    rate_dtype = jnp.promote_types(jnp.result_type(*jax.tree.leaves(template)), jnp.float32)
    return SelfAdaptiveGAState(
        population=population,
        mask=masks,
        learning_rates=jnp.full(
            (settings.population_size, settings.num_groups), INITIAL_LEARNING_RATE, rate_dtype
        ),
        generation=jnp.zeros((), jnp.int32),
        best_genotype=start.genotype,
        best_mask=start.mask,
        best_fitness=jnp.full((), jnp.nan, float),
    )


def _ask(key: PRNGKeyArray, state: SelfAdaptiveGAState) -> tuple[Population, SelfAdaptiveGAState]:
    # `tell` has made the offspring already, so that masks and rates in a state fit its genotypes.
    del key
    return state.population, state


def _tell(
    settings: _Settings,
    key: PRNGKeyArray,
    population: Population,
    fitness: Float[Array, " pop"],
    state: SelfAdaptiveGAState,
) -> tuple[SelfAdaptiveGAState, SelfAdaptiveGAMetrics]:
    # As one vector a genotype breeds several times faster on a CPU than as many leaves.
    _, unflatten = ravel_pytree(state.best_genotype)
    _, unflatten_mask = ravel_pytree(state.best_mask)
    told = (Individual(_flatten(population), _flatten(state.mask)), state.learning_rates)
    order = operators.best_first(fitness)
    parents, parent_rates = operators.take(told, order[: settings.num_parents])
    elites = operators.take(told, order[: settings.num_elites])

    num_offspring = settings.population_size - settings.num_elites
    how = _breeding(settings, state.best_genotype)
    offspring = breed(key, num_offspring, parents, parent_rates, how)
    individuals, learning_rates = jax.tree.map(
        lambda *parts: jnp.concatenate(parts), elites, offspring
    )
    new_state = SelfAdaptiveGAState(
        population=jax.vmap(unflatten)(individuals.genotype),
        mask=jax.vmap(unflatten_mask)(individuals.mask),
        learning_rates=learning_rates,
        generation=state.generation + 1,
        best_genotype=operators.take(population, order[0]),
        best_mask=operators.take(state.mask, order[0]),
        best_fitness=fitness[order[0]].astype(state.best_fitness.dtype),
    )
    metrics = SelfAdaptiveGAMetrics(
        summarise_fitness(fitness), mean_learning_rate=jnp.mean(state.learning_rates)
    )
    return new_state, metrics


def _breeding(settings: _Settings, template: Genotype) -> Breeding:
    """Returns how flattened genotypes breed."""
    num_weights = sum(leaf.size for leaf in jax.tree.leaves(template))
    tau = settings.learning_rate_tau
    if tau is None:
        # ours: the step Beyer & Schwefel (2002) advise for rugged landscapes of n dimensions
        tau = 1 / math.sqrt(2 * num_weights)
    return Breeding(
        sigma=ravel_pytree(prefixes.match_template("sigma", settings.sigma, template))[0],
        groups=ravel_pytree(
            prefixes.match_template("groups", settings.groups, template, jnp.int32)
        )[0],
        links=number_apart(prefixes.match_links(settings.links, template)),
        crossover_fraction=settings.crossover_fraction,
        mutation_fraction=settings.mutation_fraction,
        learning_rate_tau=tau,
        minimum_learning_rate=settings.minimum_learning_rate,
    )


def _flatten(population: Tree) -> Shaped[Array, "pop dim"]:
    """Returns each genotype, or mask, of a population as one vector."""
    return jax.vmap(lambda tree: ravel_pytree(tree)[0])(population)


def _check(settings: _Settings) -> None:
    checks.check_count(
        "num_elites", settings.num_elites, minimum=0, maximum=settings.population_size - 1
    )
    checks.check_numbers("sigma", settings.sigma, minimum=0.0)
    checks.check_numbers("initial_sigma", settings.initial_sigma, minimum=0.0)
    prefixes.check_links(settings.links)
    prefixes.check_mask(settings.mask)
    checks.check_numbers(
        "crossover_fraction", settings.crossover_fraction, minimum=0.0, maximum=1.0
    )
    checks.check_numbers("mutation_fraction", settings.mutation_fraction, minimum=0.0, maximum=1.0)
    checks.check_numbers(
        "crossover_fraction + mutation_fraction",
        settings.crossover_fraction + settings.mutation_fraction,
        maximum=1.0,
    )
    if settings.learning_rate_tau is not None:
        checks.check_numbers("learning_rate_tau", settings.learning_rate_tau, minimum=0.0)
    checks.check_numbers(
        "minimum_learning_rate",
        settings.minimum_learning_rate,
        above=0.0,
        maximum=INITIAL_LEARNING_RATE,
    )
