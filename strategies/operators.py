"""Operators that genetic algorithms are built from, written for one genotype; `vmap` them.

They are given their random numbers, from `draws`, so that one draw can serve many of them.
An individual is a genotype and its mask. A weight whose mask is False is a removed link: it is 0,
no mutation touches it, and only recombination with a parent that has the link brings it back.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from mjxwalk.strategies.base import BoolTree, FloatTree, Genotype, IntTree, Mask, Tree
from mjxwalk.strategies.edge import as_floats


class Individual(NamedTuple):
    """A genotype and the links it has.

    Attributes:
      genotype: weights; 0 where the mask is False.
      mask: same pytree and shapes; True where the link is present.
    """

    genotype: Genotype
    mask: Mask


def best_first(fitness: Float[Array, " pop"]) -> Int[Array, " pop"]:
    """Returns indices from best to worst; NaN comes last, ties keep their order."""
    # A sort puts NaN last whichever way it runs, so the numbers are reversed and not the result.
    return jnp.argsort(-as_floats("fitness", fitness), stable=True)


def truncation_selection(
    fitness: Float[Array, " pop"], num_parents: int
) -> Int[Array, " num_parents"]:
    """Returns the indices of the best genotypes, best first, as `best_first` orders them."""
    return best_first(fitness)[:num_parents]


def take(tree: Tree, index: Int[Array, "..."]) -> Tree:
    """Returns the rows of every leaf at an index, or at several."""
    return jax.tree.map(lambda leaf: leaf[index], tree)


def pick_pair(draws: Float[Array, "2"], num_parents: int) -> tuple[Int[Array, ""], Int[Array, ""]]:
    """Returns two different indices below `num_parents`, all pairs equally likely; 0, 0 for one.

    Args:
      draws: uniform in [0, 1).
      num_parents: how many there are.
    """
    limits = jnp.array([num_parents, num_parents - 1])
    first, offset = jnp.floor(draws * limits).astype(jnp.int32)
    return first, (first + 1 + offset) % num_parents


def choose(take_first: Bool[Array, ""] | BoolTree, first: Tree, second: Tree) -> Tree:
    """Returns `first` where told and else `second`; one boolean decides for the whole pytree."""
    if isinstance(take_first, jax.Array):
        return jax.tree.map(lambda a, b: jnp.where(take_first, a, b), first, second)
    return jax.tree.map(jnp.where, take_first, first, second)


def discrete_crossover(take_first: BoolTree, first: Individual, second: Individual) -> Individual:
    """Returns a child whose every weight, with its mask, is from the first parent where told."""
    return Individual(
        genotype=choose(take_first, first.genotype, second.genotype),
        mask=choose(take_first, first.mask, second.mask),
    )


def gaussian_mutation(individual: Individual, sigma: FloatTree, noise: FloatTree) -> Individual:
    """Returns the individual with noise added to the weights it has.

    Args:
      individual: parent; its mask is kept.
      sigma: standard deviation for each weight, in the genotype's shapes.
      noise: standard normal numbers in the same shapes.
    """
    moved = jax.tree.map(
        lambda w, s, z: w + s * z.astype(w.dtype), individual.genotype, sigma, noise
    )
    return individual._replace(genotype=remove_masked(moved, individual.mask))


def uniform_mutation(
    genotype: Float[Array, " dim"],
    lower: Float[Array, " dim"],
    upper: Float[Array, " dim"],
    rate: float | Float[Array, ""],
    draws: Float[Array, "2 dim"],
) -> Float[Array, " dim"]:
    """Returns the genotype with some weights drawn anew between their bounds.

    Args:
      genotype: to copy.
      lower: bound.
      upper: bound.
      rate: probability for each weight.
      draws: uniform in [0, 1): which weights, and their values.
    """
    drawn = lower + (upper - lower) * draws[1].astype(genotype.dtype)
    return jnp.where(draws[0] < rate, drawn, genotype)


def remove_masked(genotype: Genotype, mask: Mask) -> Genotype:
    """Returns the genotype with 0 where the mask is False, whatever stood there, NaN too."""
    return jax.tree.map(lambda w, m: jnp.where(m, w, jnp.zeros_like(w)), genotype, mask)


def log_normal_step(
    learning_rates: Float[Array, " groups"],
    noise: Float[Array, " groups"],
    *,
    tau: float | int | Float[Array, ""],
    minimum: float | int | Float[Array, ""],
) -> Float[Array, " groups"]:
    """Returns learning rates times exp(tau noise), at least `minimum`.

    With standard normal noise, log-normal self-adaptation keeps a rate positive and is as likely to
    halve as to double it: Beyer & Schwefel (2002), "Evolution strategies: a comprehensive
    introduction", Natural Computing 1(1):3-52, doi 10.1023/A:1015059928466.
    """
    dtype = learning_rates.dtype
    factor = jnp.exp(jnp.asarray(tau, dtype) * noise.astype(dtype))
    return jnp.maximum(learning_rates * factor, jnp.asarray(minimum, dtype))


def scale_by_group(
    learning_rates: Float[Array, " groups"],
    groups: IntTree,
    sigma: FloatTree,
) -> FloatTree:
    """Returns each weight's `sigma` times the learning rate of the weight's group."""
    return jax.tree.map(lambda g, s: learning_rates[g].astype(s.dtype) * s, groups, sigma)
