"""Masks that evolve beside a strategy that knows none, so that any strategy can lose links.

A generation's masks are a population of their own, one for each genotype. Those of the fittest
genotypes are parents: every other mask takes each link from either of two of them. That is how
masks are inherited in Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient
2D and 3D bipedal walking over rough terrain", Adaptive Behavior 21(1), section 2.7, but for the
weights, which go the strategy's own way. That they part is ours: a strategy that draws genotypes
from a distribution has no parents to inherit from. Selection makes all masks alike within a few
generations, and the distribution then fits the links that are left.
"""

from typing import Any, NamedTuple, Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk.strategies import draws, operators, prefixes
from mjxwalk.strategies.base import Genotype, Masks, Population, Strategy, Tree
from mjxwalk.strategies.self_adaptive_breeding import number_apart
from mjxwalk.strategies.self_adaptive_ga import PARENT_FRACTION


@runtime_checkable
class CarriesMasks(Protocol):
    """A state in which masks belong to individuals, as that of `self_adaptive_ga`.

    Its strategy's `ask` hands out `population`, and `tell` reads `mask`.
    """

    @property
    def population(self) -> Population:
        """Genotypes to be evaluated next, 0 where they have no link."""
        ...

    @property
    def mask(self) -> Masks:
        """True where an individual of that generation has the link."""
        ...


class EvolvingMasksState(NamedTuple):
    """State of a strategy beside which masks evolve.

    Attributes:
      inner: the strategy's own state.
      drawn: genotypes as the strategy handed them out.
      population: the same, 0 where the mask is False.
      mask: True where a genotype of the generation that is evaluated next has the link.
    """

    inner: Any
    drawn: Population
    population: Population
    mask: Masks


def with_evolving_masks(
    strategy: Strategy[Any, Any], *, links: Tree, num_elites: int
) -> Strategy[Any, Any]:
    """Returns the strategy over weights and masks; itself if its state carries masks already.

    The strategy is told a genotype as it was evaluated where it has a link, and as it was drawn
    where it has none: what is absent tells it nothing, and does not pull it to 0.

    Args:
      strategy: any.
      links: number of the link that each weight belongs to, as `prefixes.match_links` takes.
      num_elites: masks of the best genotypes that go on unchanged, to the front, best first: those
        of a strategy that puts as many elites there, or more, stay with them.
    """
    num_parents = max(1, round(PARENT_FRACTION * strategy.population_size))

    def init(key: PRNGKeyArray, template: Genotype) -> Any:
        return carry(strategy, strategy.init(key, template))

    def ask(key: PRNGKeyArray, state: Any) -> tuple[Population, Any]:
        if not isinstance(state, EvolvingMasksState):
            return strategy.ask(key, state)
        drawn, inner = strategy.ask(key, state.inner)
        population = operators.remove_masked(drawn, state.mask)
        return population, EvolvingMasksState(inner, drawn, population, state.mask)

    def tell(
        key: PRNGKeyArray, population: Population, fitness: Float[Array, " pop"], state: Any
    ) -> tuple[Any, Any]:
        if not isinstance(state, EvolvingMasksState):
            return strategy.tell(key, population, fitness, state)
        key_tell, key_masks = jax.random.split(key)
        told = jax.tree.map(jnp.where, state.mask, population, state.drawn)
        inner, metrics = strategy.tell(key_tell, told, fitness, state.inner)
        best = operators.best_first(fitness)[: max(num_parents, num_elites)]
        numbers = number_apart(prefixes.match_links(links, one_of(population)))
        masks = recombine_masks(
            key_masks,
            operators.take(state.mask, best),
            numbers,
            num_parents,
            num_elites,
            len(fitness),
        )
        return state._replace(inner=inner, mask=masks), metrics

    return Strategy(population_size=strategy.population_size, init=init, ask=ask, tell=tell)


def carry(strategy: Strategy[Any, Any], state: Any) -> Any:
    """Returns a strategy's state with masks that have all links; itself if it carries masks."""
    if isinstance(state, CarriesMasks):
        return state
    shapes, _ = jax.eval_shape(strategy.ask, jax.random.key(0), state)
    nothing = jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), shapes)
    everything = jax.tree.map(lambda leaf: jnp.ones(leaf.shape, bool), shapes)
    return EvolvingMasksState(state, nothing, nothing, everything)


def one_of(population: Population) -> Genotype:
    """Returns the first genotype of a population, for its shapes."""
    return operators.take(population, jnp.asarray(0))


def recombine_masks(
    key: PRNGKeyArray,
    best: Tree,
    links: Int[np.ndarray, " dim"],
    num_parents: int,
    num_elites: int,
    num_masks: int,
) -> Masks:
    """Returns the masks of the next generation.

    Args:
      key: random key, used up.
      best: masks of the fittest, best first; at least `num_parents` and `num_elites` of them.
      links: number of each weight's link, without gaps; weights of a link go together.
      num_parents: of how many every offspring has two for parents.
      num_elites: how many are copied to the front.
      num_masks: in all.
    """
    _, unflatten = ravel_pytree(operators.take(best, jnp.asarray(0)))
    flat = jax.vmap(lambda tree: ravel_pytree(tree)[0])(best)
    num_links = int(links.max()) + 1
    sizes = (2, draws.num_words(num_links))
    picks, tosses = draws.draw_words(key, num_masks - num_elites, sizes)
    pick = jax.vmap(operators.pick_pair, in_axes=(0, None))
    first, second = pick(draws.uniforms(picks), num_parents)
    take_first = draws.coins(tosses, num_links)[:, links]
    offspring = jnp.where(take_first, flat[first], flat[second])
    return jax.vmap(unflatten)(jnp.concatenate([flat[:num_elites], offspring]))
