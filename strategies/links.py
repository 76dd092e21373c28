"""Links: sets of weights that come and go together, and how pruning takes them out.

Solomon, Locascio & Hartmann (2013), Adaptive Behavior 21(1), doi 10.1177/1059712312462904, section
2.7.5. Which weights are one link is told by numbers in a genotype's shapes, from
`prefixes.match_links`: weights of the same number are one link, weights of -1 stay for good.
"""

import math

import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from mjxwalk.strategies import draws, operators
from mjxwalk.strategies.base import IntTree, Mask, Masks
from mjxwalk.strategies.operators import Individual

SURVIVAL_THRESHOLD = 0.8  # Solomon et al. (2013), section 2.7.5: 40 of 50 runs


def present_links(mask: Mask, links: IntTree) -> Bool[Array, " weight"]:
    """Returns, by its number, whether a link is there: whether a weight of it is.

    There are as many places as weights, which is enough for all links; those without one are False.
    """
    present, numbers = ravel_pytree(mask)[0], ravel_pytree(links)[0]
    nowhere = numbers.size
    places = jnp.where(numbers < 0, nowhere, numbers)
    return jnp.zeros(numbers.size, bool).at[places].max(present, mode="drop")


def count_links(mask: Mask, links: IntTree) -> Int[Array, ""]:
    """Returns how many links are there, of those that can be removed."""
    return jnp.sum(present_links(mask, links), dtype=jnp.int32)


def remove_random_link(key: PRNGKeyArray, individual: Individual, links: IntTree) -> Individual:
    """Returns the individual without one of its links, all equally likely; as it is without any.

    Args:
      key: random key, used up.
      individual: genotype and mask.
      links: number of each weight's link.
    """
    (words,) = draws.draw_words(key, 1, [ravel_pytree(links)[0].size])
    return _remove_highest(draws.uniforms(words[0]), individual, links)


def prune_population(
    key: PRNGKeyArray, individuals: Individual, links: IntTree, keep: Bool[Array, " pop"]
) -> Individual:
    """Returns the individuals, each without one more of its links, except those to keep.

    Args:
      key: random key, used up.
      individuals: leaves with a population axis in front.
      links: number of each weight's link, in one genotype's shapes.
      keep: individuals that lose nothing, such as the elite.
    """
    (words,) = draws.draw_words(key, keep.size, [ravel_pytree(links)[0].size])
    remove = jax.vmap(_remove_highest, in_axes=(0, 0, None))
    pruned = remove(draws.uniforms(words), individuals, links)
    return jax.vmap(operators.choose)(keep, individuals, pruned)


def _remove_highest(
    scores: Float[Array, " link"], individual: Individual, links: IntTree
) -> Individual:
    """Returns the individual without the one of its links that has the highest score."""
    present, unflatten = ravel_pytree(individual.mask)
    numbers = ravel_pytree(links)[0]
    # All weights of a link share its score, so that their number does not count.
    by_weight = jnp.where(present & (numbers >= 0), scores[numbers], -1.0)
    chosen = jnp.argmax(by_weight)
    stays = present & ((numbers != numbers[chosen]) | (by_weight[chosen] < 0))
    mask = unflatten(stays)
    return Individual(operators.remove_masked(individual.genotype, mask), mask)


def survival(masks: Masks) -> IntTree:
    """Returns in how many runs each weight's link is left.

    Args:
      masks: one of each run, leaves [run, ...].
    """
    return jax.tree.map(lambda mask: jnp.sum(mask, axis=0), masks)


def reduce_links(
    survivors: IntTree, num_runs: int, *, threshold: float = SURVIVAL_THRESHOLD
) -> Mask:
    """Returns the mask of what is left in at least a share of the runs.

    Args:
      survivors: number of runs in which each weight's link is left, from `survival`.
      num_runs: how many there were.
      threshold: share of the runs.
    """
    # Counts are compared, for 40 of 50 as a floating-point share may be below 0.8.
    enough = math.ceil(threshold * num_runs - 1e-9)
    return jax.tree.map(lambda count: count >= enough, survivors)
