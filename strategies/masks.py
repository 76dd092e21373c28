"""Fixed masks for any strategy: weights that are absent are 0 and no dimension of the search."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.strategies import prefixes
from mjxwalk.strategies.base import Genotype, Population, Strategy, Tree


class MaskedState(NamedTuple):
    """State of a strategy that searches over some of the weights.

    Attributes:
      inner: the strategy's own state; its template has a vector of the present weights in place of
        each leaf.
      template: genotype that the search started from, with 0 where the mask is False.
    """

    inner: Any
    template: Genotype


def with_mask(strategy: Strategy[Any, Any], mask: Tree) -> Strategy[MaskedState, Any]:
    """Returns the strategy over the weights that a mask leaves.

    Args:
      strategy: any. Settings of it that are pytree prefixes may hold a value for each leaf of the
        template, but none for each weight of a leaf.
      mask: True for the weights that are there, as a pytree prefix of the template; not traced.

    Raises:
      ValueError: the mask holds something else than booleans, or, from `init`, does not fit the
        template or leaves none of its weights.
    """
    prefixes.check_mask(mask)

    def places(template: Genotype) -> list[np.ndarray]:
        full = prefixes.match_present(mask, template)
        return [np.flatnonzero(leaf) for leaf in jax.tree.leaves(full)]

    def compress(population: Population, template: Genotype) -> Population:
        leaves, structure = jax.tree.flatten(population)
        chosen = [
            leaf.reshape(leaf.shape[0], -1)[:, place]
            for leaf, place in zip(leaves, places(template), strict=True)
        ]
        return jax.tree.unflatten(structure, chosen)

    def expand(population: Population, template: Genotype) -> Population:
        leaves, structure = jax.tree.flatten(template)
        rows = strategy.population_size
        whole = [
            jnp.zeros((rows, leaf.size), leaf.dtype)
            .at[:, place]
            .set(part)
            .reshape(rows, *leaf.shape)
            for leaf, part, place in zip(
                leaves, jax.tree.leaves(population), places(template), strict=True
            )
        ]
        return jax.tree.unflatten(structure, whole)

    def init(key: PRNGKeyArray, template: Genotype) -> MaskedState:
        one = jax.tree.map(lambda leaf: leaf[None], template)
        present = jax.tree.map(lambda leaf: leaf[0], compress(one, template))
        if not sum(leaf.size for leaf in jax.tree.leaves(present)):
            raise ValueError("mask must leave at least one weight, got none")
        start = jax.tree.map(
            lambda leaf, there: jnp.where(there, leaf, jnp.zeros_like(leaf)),
            template,
            prefixes.match_present(mask, template),
        )
        return MaskedState(strategy.init(key, present), start)

    def ask(key: PRNGKeyArray, state: MaskedState) -> tuple[Population, MaskedState]:
        population, inner = strategy.ask(key, state.inner)
        return expand(population, state.template), state._replace(inner=inner)

    def tell(
        key: PRNGKeyArray,
        population: Population,
        fitness: Float[Array, " pop"],
        state: MaskedState,
    ) -> tuple[MaskedState, Any]:
        present = compress(population, state.template)
        inner, metrics = strategy.tell(key, present, fitness, state.inner)
        return state._replace(inner=inner), metrics

    return Strategy(population_size=strategy.population_size, init=init, ask=ask, tell=tell)
