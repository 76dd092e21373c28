"""Genotypes as vectors, for strategies that make no difference between weights.

The search runs on one vector a genotype, in float32 or better whatever the template's dtype is, so
that small steps of a bfloat16 population add up. Only what is handed out has the template's shapes.
"""

from collections.abc import Callable
from typing import Protocol, TypeVar, runtime_checkable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.strategies import draws, prefixes
from mjxwalk.strategies.base import Genotype, MetricsT, Population, Strategy, Tree

# ours: with these the squares of all step sizes are normal numbers in float32.
SMALLEST_SIGMA = 1e-18
LARGEST_SIGMA = 1e18


@runtime_checkable
class VectorState(Protocol):
    """A state that keeps the shapes of the genotypes that its vectors stand for."""

    @property
    def template(self) -> Genotype:
        """Genotype that the search started from."""
        ...


VectorStateT = TypeVar("VectorStateT", bound=VectorState)


def over_vectors(
    *,
    population_size: int,
    init: Callable[[Genotype], VectorStateT],
    ask: Callable[[PRNGKeyArray, VectorStateT], Float[Array, "pop dim"]],
    tell: Callable[
        [Float[Array, "pop dim"], Float[Array, " pop"], VectorStateT],
        tuple[VectorStateT, MetricsT],
    ],
) -> Strategy[VectorStateT, MetricsT]:
    """Returns a strategy over pytrees from a search that knows genotypes as vectors.

    All chance is in `ask`: the same genotypes and fitness lead to the same state.

    Args:
      population_size: genotypes in a generation.
      init: makes the first state from a template, whose vector `flatten` gives.
      ask: draws the genotypes to evaluate; uses up its key.
      tell: makes the next state, and metrics, from genotypes, fitness and state.
    """

    def init_tree(key: PRNGKeyArray, template: Genotype) -> VectorStateT:
        del key
        return init(template)

    def ask_tree(key: PRNGKeyArray, state: VectorStateT) -> tuple[Population, VectorStateT]:
        return unflatten_population(ask(key, state), state.template), state

    def tell_tree(
        key: PRNGKeyArray,
        population: Population,
        fitness: Float[Array, " pop"],
        state: VectorStateT,
    ) -> tuple[VectorStateT, MetricsT]:
        del key
        return tell(flatten_population(population), fitness, state)

    return Strategy(population_size=population_size, init=init_tree, ask=ask_tree, tell=tell_tree)


def flatten(genotype: Genotype) -> Float[Array, " dim"]:
    """Returns all weights as one vector, in float32 or better."""
    return flatten_population(jax.tree.map(lambda leaf: jnp.asarray(leaf)[None], genotype))[0]


def flatten_population(population: Population) -> Float[Array, "pop dim"]:
    """Returns a vector for each genotype, in float32 or better."""
    leaves = [leaf.reshape(leaf.shape[0], -1) for leaf in jax.tree.leaves(population)]
    dtype = jnp.promote_types(jnp.result_type(*leaves), jnp.float32)
    return jnp.concatenate([leaf.astype(dtype) for leaf in leaves], axis=1)


def unflatten_population(vectors: Float[Array, "pop dim"], template: Genotype) -> Population:
    """Returns vectors as genotypes in the template's shapes and dtypes."""
    leaves, structure = jax.tree.flatten(template)
    parts: list[Array] = []
    start = 0
    for leaf in leaves:
        part = vectors[:, start : start + leaf.size]
        parts.append(part.reshape(part.shape[0], *leaf.shape).astype(leaf.dtype))
        start += leaf.size
    return jax.tree.unflatten(structure, parts)


def unflatten(vector: Float[Array, " dim"], template: Genotype) -> Genotype:
    """Returns a vector, such as the mean in a strategy's state, as a genotype."""
    return jax.tree.map(lambda leaf: leaf[0], unflatten_population(vector[None], template))


def spread(field: str, prefix: Tree, template: Genotype) -> Float[Array, " dim"]:
    """Returns a setting, one value or a pytree prefix of the template, as a value for each weight.

    Raises:
      ValueError: it does not fit the template; see `prefixes.match_template`.
    """
    leaves = jax.tree.leaves(template)
    dtype = jnp.promote_types(jnp.result_type(*leaves), jnp.float32)
    return flatten(prefixes.match_template(field, prefix, template, dtype))


def standard_normals(
    key: PRNGKeyArray, num_rows: int, like: Float[Array, " dim"]
) -> Float[Array, "row dim"]:
    """Returns independent standard normal numbers in rows like a vector; uses up `key`."""
    (words,) = draws.draw_words(key, num_rows, [like.size])
    return draws.normals(words).astype(like.dtype)


def mirrored_normals(
    key: PRNGKeyArray, num_rows: int, like: Float[Array, " dim"]
) -> Float[Array, "row dim"]:
    """Returns standard normal numbers whose second half is the first, negated; uses up `key`."""
    half = standard_normals(key, num_rows // 2, like)
    return jnp.concatenate([half, -half])


def bound_sigma(sigma: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
    """Returns step sizes kept within what arithmetic can hold."""
    return jnp.clip(sigma, SMALLEST_SIGMA, LARGEST_SIGMA)
