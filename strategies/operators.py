"""Operators that genetic algorithms are built from, written for one genotype; `vmap` them.

An individual is a genotype and its mask. A weight whose mask is False is a removed link: it is 0,
no mutation touches it, and only recombination with a parent that has the link brings it back.
"""

import math
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from mjxwalk.strategies.base import BoolTree, FloatTree, Genotype, IntTree, Mask, Tree


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
    return jnp.argsort(-fitness, stable=True)


def truncation_selection(
    fitness: Float[Array, " pop"], num_parents: int
) -> Int[Array, " num_parents"]:
    """Returns the indices of the best genotypes, best first, as `best_first` orders them."""
    return best_first(fitness)[:num_parents]


def take(tree: Tree, index: Int[Array, "..."]) -> Tree:
    """Returns the rows of every leaf at an index, or at several."""
    return jax.tree.map(lambda leaf: leaf[index], tree)


def draw_pair(key: PRNGKeyArray, num_parents: int) -> tuple[Int[Array, ""], Int[Array, ""]]:
    """Returns two different indices below `num_parents`, all pairs equally likely; 0, 0 for one."""
    # `randint` would take eight times the random words to rid itself of a bias near 1e-7.
    draws = jax.random.uniform(key, (2,))
    limits = jnp.array([num_parents, num_parents - 1])
    first, offset = jnp.floor(draws * limits).astype(jnp.int32)
    return first, (first + 1 + offset) % num_parents


def normal_like(key: PRNGKeyArray, tree: FloatTree) -> Tree:
    """Returns independent standard normal numbers in the shapes and dtypes of a pytree."""
    # Drawn in float32 at least: JAX's narrow normals have too few bits for their tails.
    leaves = jax.tree.leaves(tree)
    dtype = jnp.promote_types(jnp.result_type(*leaves), jnp.float32)
    flat = jax.random.normal(key, (sum(leaf.size for leaf in leaves),), dtype)
    return jax.tree.map(lambda part, leaf: part.astype(leaf.dtype), _split_like(flat, tree), tree)


def coins_like(key: PRNGKeyArray, tree: Tree) -> BoolTree:
    """Returns independent fair booleans in the shapes of a pytree."""
    # A word holds 32 coins; a `bernoulli` draws a word for each and takes several times as long.
    size = sum(leaf.size for leaf in jax.tree.leaves(tree))
    words = jax.random.bits(key, (math.ceil(size / 32),), jnp.uint32)
    bits = (words[:, None] >> jnp.arange(32, dtype=jnp.uint32)) & 1
    return _split_like(bits.astype(bool).reshape(-1)[:size], tree)


def choose(take_first: Bool[Array, ""] | BoolTree, first: Tree, second: Tree) -> Tree:
    """Returns `first` where told and else `second`; one boolean decides for the whole pytree."""
    if isinstance(take_first, jax.Array):
        return jax.tree.map(lambda a, b: jnp.where(take_first, a, b), first, second)
    return jax.tree.map(jnp.where, take_first, first, second)


def discrete_crossover(key: PRNGKeyArray, first: Individual, second: Individual) -> Individual:
    """Returns a child whose every weight, with its mask, is from either parent by a fair coin."""
    take_first = coins_like(key, first.genotype)
    return Individual(
        genotype=choose(take_first, first.genotype, second.genotype),
        mask=choose(take_first, first.mask, second.mask),
    )


def gaussian_mutation(key: PRNGKeyArray, individual: Individual, sigma: FloatTree) -> Individual:
    """Returns the individual with normal noise added to the weights it has.

    Args:
      key: random key, used up.
      individual: parent; its mask is kept.
      sigma: standard deviation for each weight, in the genotype's shapes.
    """
    noise = normal_like(key, individual.genotype)
    moved = jax.tree.map(lambda w, s, z: w + s * z, individual.genotype, sigma, noise)
    return individual._replace(genotype=remove_masked(moved, individual.mask))


def remove_masked(genotype: Genotype, mask: Mask) -> Genotype:
    """Returns the genotype with 0 where the mask is False, whatever stood there, NaN too."""
    return jax.tree.map(lambda w, m: jnp.where(m, w, jnp.zeros_like(w)), genotype, mask)


def log_normal_step(
    key: PRNGKeyArray,
    learning_rates: Float[Array, " groups"],
    *,
    tau: float | int | Float[Array, ""],
    minimum: float | int | Float[Array, ""],
) -> Float[Array, " groups"]:
    """Returns learning rates times exp(tau N(0, 1)), each with its own draw, at least `minimum`.

    Log-normal self-adaptation keeps a rate positive and is as likely to halve as to double it:
    Beyer & Schwefel (2002), "Evolution strategies: a comprehensive introduction", Natural Computing
    1(1):3-52, doi 10.1023/A:1015059928466.
    """
    noise = normal_like(key, learning_rates)
    factor = jnp.exp(jnp.asarray(tau, learning_rates.dtype) * noise)
    return jnp.maximum(learning_rates * factor, jnp.asarray(minimum, learning_rates.dtype))


def scale_by_group(
    learning_rates: Float[Array, " groups"],
    groups: IntTree,
    sigma: FloatTree,
) -> FloatTree:
    """Returns each weight's `sigma` times the learning rate of the weight's group."""
    return jax.tree.map(lambda g, s: learning_rates[g].astype(s.dtype) * s, groups, sigma)


def _split_like(flat: Array, tree: Tree) -> Tree:
    """Returns consecutive pieces of a vector in the shapes of a pytree."""
    leaves, structure = jax.tree.flatten(tree)
    ends = [0]
    for leaf in leaves:
        ends.append(ends[-1] + leaf.size)
    pieces = [
        flat[start:end].reshape(leaf.shape)
        for start, end, leaf in zip(ends, ends[1:], leaves, strict=False)
    ]
    return jax.tree.unflatten(structure, pieces)
