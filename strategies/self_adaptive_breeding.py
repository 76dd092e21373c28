"""How the self-adaptive genetic algorithm makes offspring: by crossover, mutation or both.

Solomon, Locascio & Hartmann (2013), Adaptive Behavior 21(1), doi 10.1177/1059712312462904, section
2.7.3; `self_adaptive_ga` says what the paper states and what is ours. Genotypes are vectors here.
"""

from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from mjxwalk.strategies import draws, operators
from mjxwalk.strategies.base import ScalarLike, Tree
from mjxwalk.strategies.operators import Individual


class Breeding(NamedTuple):
    """How offspring are made.

    Attributes:
      sigma: standard deviation of mutation at a learning rate of 1, for each weight.
      groups: index of each weight's learning rate.
      links: number of the link each weight belongs to, from 0 without gaps: weights of a link come
        from the same parent.
      crossover_fraction: see `pick_operators`.
      mutation_fraction: see `pick_operators`.
      learning_rate_tau: see `operators.log_normal_step`.
      minimum_learning_rate: smallest learning rate.
    """

    sigma: Float[Array, " dim"]
    groups: Int[Array, " dim"]
    links: Int[np.ndarray, " dim"]
    crossover_fraction: ScalarLike
    mutation_fraction: ScalarLike
    learning_rate_tau: ScalarLike
    minimum_learning_rate: ScalarLike


class Draws(NamedTuple):
    """The random numbers that make one offspring.

    Attributes:
      pair: uniform in [0, 1), for the two parents.
      operators: uniform in [0, 1), for what is done to them.
      take_first: fair, for each weight.
      take_first_rate: fair, for each learning rate.
      rate_noise: standard normal, for each learning rate.
      noise: standard normal, for each weight.
    """

    pair: Float[Array, "*offspring 2"]
    operators: Float[Array, "*offspring"]
    take_first: Bool[Array, "*offspring dim"]
    take_first_rate: Bool[Array, "*offspring groups"]
    rate_noise: Float[Array, "*offspring groups"]
    noise: Float[Array, "*offspring dim"]


def number_apart(links: Tree) -> Int[np.ndarray, " dim"]:
    """Returns numbers from `prefixes.match_links` as one vector, with a new one for each -1."""
    numbers = np.concatenate([leaf.reshape(-1) for leaf in jax.tree.leaves(links)])
    alone = numbers < 0
    numbers[alone] = numbers.max() + 1 + np.arange(alone.sum())
    return numbers


def breed(
    key: PRNGKeyArray,
    num_offspring: int,
    parents: Individual,
    learning_rates: Float[Array, "parents groups"],
    how: Breeding,
) -> tuple[Individual, Float[Array, "offspring groups"]]:
    """Returns offspring of randomly drawn parents, and their learning rates.

    Args:
      key: random key, used up.
      num_offspring: how many.
      parents: individuals to draw from, with an axis of parents in front.
      learning_rates: the parents' rates.
      how: its settings.
    """
    drawn = draw(key, num_offspring, how.links, learning_rates.shape[1])
    make = jax.vmap(make_offspring, in_axes=(0, None, None, None))
    return make(drawn, parents, learning_rates, how)


def draw(
    key: PRNGKeyArray, num_offspring: int, links: Int[np.ndarray, " dim"], num_groups: int
) -> Draws:
    """Returns what so many offspring take, with an axis of offspring in front; uses up `key`."""
    num_links = int(links.max()) + 1
    num_coins = num_links + num_groups
    sizes = (3, draws.num_words(num_coins), num_groups + links.size)
    picks, tosses, moves = draws.draw_words(key, num_offspring, sizes)
    picks, coins = draws.uniforms(picks), draws.coins(tosses, num_coins)
    # Cut in two only now: XLA on a CPU then makes the normals by themselves, and vectorised, while
    # in one loop with the lookup of parents they take three times as long.
    noise = draws.normals(moves)
    # Where every weight is a link, so many coins need no looking up.
    every_weight = num_links == links.size
    return Draws(
        pair=picks[:, :2],
        operators=picks[:, 2],
        take_first=coins[:, :num_links] if every_weight else coins[:, links],
        take_first_rate=coins[:, num_links:],
        rate_noise=noise[:, :num_groups],
        noise=noise[:, num_groups:],
    )


def pick_operators(
    draw: Float[Array, ""], crossover_fraction: ScalarLike, mutation_fraction: ScalarLike
) -> tuple[Bool[Array, ""], Bool[Array, ""]]:
    """Returns whether an offspring is made by crossover, and whether it is mutated; never neither.

    Args:
      draw: uniform in [0, 1).
      crossover_fraction: probability of crossover alone.
      mutation_fraction: probability of mutation alone; else crossover, then mutation.
    """
    mutates = draw >= crossover_fraction
    only_mutates = mutates & (draw < crossover_fraction + mutation_fraction)
    return ~only_mutates, mutates


def make_offspring(
    drawn: Draws,
    parents: Individual,
    learning_rates: Float[Array, "parents groups"],
    how: Breeding,
) -> tuple[Individual, Float[Array, " groups"]]:
    """Returns one offspring and its learning rates; arguments as `breed`."""
    index_first, index_second = operators.pick_pair(drawn.pair, learning_rates.shape[0])
    first, first_rates = operators.take((parents, learning_rates), index_first)
    second, second_rates = operators.take((parents, learning_rates), index_second)
    crosses, mutates = pick_operators(
        drawn.operators, how.crossover_fraction, how.mutation_fraction
    )
    child = operators.discrete_crossover(drawn.take_first | ~crosses, first, second)
    rates = operators.choose(drawn.take_first_rate | ~crosses, first_rates, second_rates)

    stepped_rates = operators.log_normal_step(
        rates,
        drawn.rate_noise,
        tau=how.learning_rate_tau,
        minimum=how.minimum_learning_rate,
    )
    scale = operators.scale_by_group(stepped_rates, how.groups, how.sigma)
    mutant = operators.gaussian_mutation(child, scale, drawn.noise)
    return operators.choose(mutates, (mutant, stepped_rates), (child, rates))
