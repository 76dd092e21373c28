"""How the self-adaptive genetic algorithm makes one offspring: crossover, mutation or both.

Solomon, Locascio & Hartmann (2013), Adaptive Behavior 21(1), doi 10.1177/1059712312462904, section
2.7.3; `self_adaptive_ga` says what the paper states and what is ours.
"""

from typing import TypeAlias

import jax
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from mjxwalk.strategies import operators
from mjxwalk.strategies.base import FloatTree, IntTree
from mjxwalk.strategies.operators import Individual

ScalarLike: TypeAlias = float | int | Float[Array, ""]


def draw_operators(
    key: PRNGKeyArray, crossover_fraction: ScalarLike, mutation_fraction: ScalarLike
) -> tuple[Bool[Array, ""], Bool[Array, ""]]:
    """Returns whether an offspring is made by crossover, and whether it is mutated; never neither.

    Args:
      key: random key, used up.
      crossover_fraction: probability of crossover alone.
      mutation_fraction: probability of mutation alone; else crossover, then mutation.
    """
    draw = jax.random.uniform(key)
    mutates = draw >= crossover_fraction
    only_mutates = mutates & (draw < crossover_fraction + mutation_fraction)
    return ~only_mutates, mutates


def make_offspring(
    key: PRNGKeyArray,
    parents: Individual,
    learning_rates: Float[Array, "parents groups"],
    *,
    sigma: FloatTree,
    groups: IntTree,
    crossover_fraction: ScalarLike,
    mutation_fraction: ScalarLike,
    learning_rate_tau: ScalarLike,
    minimum_learning_rate: ScalarLike,
) -> tuple[Individual, Float[Array, " groups"]]:
    """Returns one offspring of randomly drawn parents, and its learning rates.

    Args:
      key: random key, used up.
      parents: individuals to draw from, with an axis of parents in front of each leaf.
      learning_rates: the parents' rates.
      sigma: standard deviation of mutation at a learning rate of 1, in one genotype's shapes.
      groups: index of each weight's learning rate, in one genotype's shapes.
      crossover_fraction: see `draw_operators`.
      mutation_fraction: see `draw_operators`.
      learning_rate_tau: see `operators.log_normal_step`.
      minimum_learning_rate: smallest learning rate.
    """
    key_pair, key_operators, key_weights, key_rates, key_step, key_mutation = jax.random.split(
        key, 6
    )
    index_first, index_second = operators.draw_pair(key_pair, learning_rates.shape[0])
    first, first_rates = operators.take((parents, learning_rates), index_first)
    second, second_rates = operators.take((parents, learning_rates), index_second)
    crosses, mutates = draw_operators(key_operators, crossover_fraction, mutation_fraction)

    crossed = operators.discrete_crossover(key_weights, first, second)
    child = operators.choose(crosses, crossed, first)
    take_first = operators.coins_like(key_rates, first_rates) | ~crosses
    child_rates = operators.choose(take_first, first_rates, second_rates)

    stepped_rates = operators.log_normal_step(
        key_step, child_rates, tau=learning_rate_tau, minimum=minimum_learning_rate
    )
    scale = operators.scale_by_group(stepped_rates, groups, sigma)
    mutant = operators.gaussian_mutation(key_mutation, child, scale)
    return operators.choose(mutates, (mutant, stepped_rates), (child, child_rates))
