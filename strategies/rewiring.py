"""Rewiring: the weakest links of a network go, and as many others may grow at random places.

Mocanu, Mocanu, Stone, Nguyen, Gibescu & Liotta (2018), "Scalable training of artificial neural
networks with adaptive sparse connectivity inspired by network science", Nature Communications 9,
doi 10.1038/s41467-018-04316-3, algorithm 2: sparse evolutionary training. Every so often the share
zeta of each layer's links that is nearest to zero is removed, and as many grow at random.

Ours: the network begins with all its links, as a gait is easier to find with them, and loses the
weakest share time after time until the wanted density is reached; from then on every removal is
followed by growth, as in the paper. A link that grows has what the strategy draws for it.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks, draws, operators, prefixes
from mjxwalk.strategies.base import Genotype, Population, Strategy, Tree
from mjxwalk.strategies.evolving_masks import (
    EvolvingMasksState,
    carry,
    one_of,
    with_evolving_masks,
)
from mjxwalk.strategies.links import count_links, present_links
from mjxwalk.strategies.metrics import FitnessSummary, of_fitness, summarise_fitness

FRACTION = 0.3  # Mocanu et al. (2018), zeta
EVERY = 10  # generations; ours: as often as links are pruned in Solomon et al. (2013)
DENSITY = 0.2  # ours


class RewiringState(NamedTuple):
    """State of a strategy whose networks are rewired.

    Attributes:
      inner: the strategy's own state if that carries masks, else an `EvolvingMasksState`.
      age: generations told.
    """

    inner: Any
    age: Int[Array, ""]


class RewiringMetrics(NamedTuple):
    """Scalars about the generation told.

    Attributes:
      fitness: summary of the generation's fitness.
      mean_num_links: links that an individual has, of those that can be removed.
      sigma: of strategies that tell one; None of others.
      mean_learning_rate: of strategies that tell one; None of others.
    """

    fitness: FitnessSummary
    mean_num_links: Float[Array, ""]
    sigma: Float[Array, ""] | None
    mean_learning_rate: Float[Array, ""] | None
    __getattr__ = of_fitness


class _Wanted(NamedTuple):
    """Checked arguments of `with_rewiring`."""

    fraction: float
    density: float


class _Layers(NamedTuple):
    """Links by their number, with as many places as weights.

    Attributes:
      links: number of each weight's link, in a genotype's shapes.
      layer: of each link; -1 of places without one.
    """

    links: Tree
    layer: Int[np.ndarray, " link"]


def with_rewiring(
    strategy: Strategy[Any, Any],
    *,
    links: Tree,
    groups: Tree = 0,
    every: int = EVERY,
    fraction: float = FRACTION,
    density: float = DENSITY,
) -> Strategy[RewiringState, RewiringMetrics]:
    """Returns the strategy over networks that lose their weakest links and grow others.

    What a network is depends on the strategy:
    - One whose state carries masks, as `self_adaptive_ga`'s does: each individual has a network of
      its own, and of the elite too the weakest links go. A link that grows is 0 at first.
    - Any other: all have one network, whose links are as strong as the mean of the population.

    Args:
      strategy: any; `self_adaptive_ga` with `links` as here, so that all weights of a link
        recombine together.
      links: as `with_pruning` takes them. A link's strength is the length of the vector of its
        weights.
      groups: number of the layer that each weight belongs to; each layer loses its own weakest
        links. One value for all weights, or a pytree prefix of the template.
      every: generations from one rewiring to the next; the first is after as many.
      fraction: share of the links that are there that goes.
      density: share of all links of a layer to which others grow again; above it none grow.

    Raises:
      ValueError: a setting is out of its range, or, from `init` or `ask`, does not fit.
    """
    checks.check_count("every", every, minimum=1)
    checks.check_numbers("fraction", fraction, above=0.0, maximum=1.0)
    checks.check_numbers("density", density, above=0.0, maximum=1.0)
    prefixes.check_links(links)
    masked = with_evolving_masks(strategy, links=links, num_elites=1)
    wanted = _Wanted(fraction, density)

    def init(key: PRNGKeyArray, template: Genotype) -> RewiringState:
        _layers(links, groups, template)  # to refuse what does not fit
        return begin(strategy.init(key, template))

    def begin(state: Any) -> RewiringState:
        return RewiringState(carry(strategy, state), jnp.zeros((), jnp.int32))

    def ask(key: PRNGKeyArray, state: RewiringState) -> tuple[Population, RewiringState]:
        population, inner = masked.ask(key, state.inner)
        return population, state._replace(inner=inner)

    def tell(
        key: PRNGKeyArray,
        population: Population,
        fitness: Float[Array, " pop"],
        state: RewiringState,
    ) -> tuple[RewiringState, RewiringMetrics]:
        key_tell, key_rewire = jax.random.split(key)
        inner, told = masked.tell(key_tell, population, fitness, state.inner)
        layers = _layers(links, groups, one_of(population))
        num_links = jax.vmap(count_links, in_axes=(0, None))(state.inner.mask, layers.links)
        age = state.age + 1

        def rewire(key: PRNGKeyArray) -> Any:
            if isinstance(inner, EvolvingMasksState):
                return _rewire_all(key, inner, layers, wanted)
            return _rewire_each(key, inner, layers, wanted)

        inner = jax.lax.cond(age % every == 0, rewire, lambda key: inner, key_rewire)
        metrics = RewiringMetrics(
            summarise_fitness(fitness),
            jnp.mean(num_links.astype(float)),
            getattr(told, "sigma", None),
            getattr(told, "mean_learning_rate", None),
        )
        return RewiringState(inner, age), metrics

    return Strategy(population_size=strategy.population_size, init=init, ask=ask, tell=tell)


def rewire_network(
    strength: Float[Array, " link"],
    present: Bool[Array, " link"],
    chance: Float[Array, " link"],
    layer: Int[np.ndarray, " link"],
    *,
    fraction: float,
    density: float,
) -> Bool[Array, " link"]:
    """Returns which links are there after the weakest have gone and others have grown.

    Args:
      strength: of each link.
      present: whether it is there.
      chance: uniform in [0, 1): of the absent ones those with the highest grow.
      layer: of each link; -1 for places without one.
      fraction: share of a layer's links that go, rounded.
      density: share of a layer's places, rounded, to which links grow.
    """
    after = present
    for number in np.unique(layer[layer >= 0]):
        inside = layer == number
        num_wanted = max(1, round(density * int(inside.sum())))  # no layer is left without a link
        there = inside & present
        num = jnp.sum(there)
        num_removed = jnp.round(fraction * num).astype(jnp.int32)
        stays = there & (_rank(jnp.where(there, -strength, jnp.inf)) < num - num_removed)
        num_grown = jnp.maximum(num_wanted - (num - num_removed), 0)
        free = inside & ~stays
        grown = free & (_rank(jnp.where(free, -chance, jnp.inf)) < num_grown)
        after = jnp.where(inside, stays | grown, after)
    return after


def _layers(links: Tree, groups: Tree, template: Genotype) -> _Layers:
    """Returns links and layers of a genotype's weights.

    Raises:
      ValueError: they do not fit the template.
    """
    numbers = prefixes.match_links(links, template)
    of_weight = prefixes.match_links(groups, template)
    flat, layers = (
        np.concatenate([leaf.reshape(-1) for leaf in jax.tree.leaves(tree)])
        for tree in (numbers, of_weight)
    )
    layer = np.full(flat.size, -1, np.int32)
    layer[flat[flat >= 0]] = layers[flat >= 0]
    return _Layers(jax.tree.map(jnp.asarray, numbers), layer)


def _rewired_mask(
    uniforms: Float[Array, " link"],
    genotype: Genotype,
    mask: Tree,
    layers: _Layers,
    wanted: _Wanted,
) -> Tree:
    """Returns the mask of one network after it is rewired."""
    flat, unflatten = ravel_pytree(mask)
    numbers = ravel_pytree(layers.links)[0]
    squares = ravel_pytree(genotype)[0].astype(float) ** 2
    places = jnp.where(numbers < 0, numbers.size, numbers)
    strength = jnp.zeros(numbers.size, float).at[places].add(squares, mode="drop")
    there = rewire_network(
        jnp.sqrt(strength),
        present_links(mask, layers.links),
        uniforms,
        layers.layer,
        fraction=wanted.fraction,
        density=wanted.density,
    )
    return unflatten(jnp.where(numbers < 0, flat, there[numbers]))


def _rewire_all(
    key: PRNGKeyArray, state: EvolvingMasksState, layers: _Layers, wanted: _Wanted
) -> EvolvingMasksState:
    """Returns the state in which the one network of all genotypes is rewired."""
    mean = jax.tree.map(lambda leaf: jnp.mean(leaf, axis=0), state.population)
    mask = operators.take(state.mask, jnp.asarray(0))
    (words,) = draws.draw_words(key, 1, [layers.layer.size])
    rewired = _rewired_mask(draws.uniforms(words[0]), mean, mask, layers, wanted)
    masks = jax.tree.map(lambda one, old: jnp.broadcast_to(one, old.shape), rewired, state.mask)
    return state._replace(mask=masks)


def _rewire_each(key: PRNGKeyArray, state: Any, layers: _Layers, wanted: _Wanted) -> Any:
    """Returns the state in which each individual's own network is rewired."""
    size = jax.tree.leaves(state.population)[0].shape[0]
    (words,) = draws.draw_words(key, size, [layers.layer.size])

    def rewire(chance: Float[Array, " link"], genotype: Genotype, mask: Tree) -> Tree:
        return _rewired_mask(chance, genotype, mask, layers, wanted)

    masks = jax.vmap(rewire)(draws.uniforms(words), state.population, state.mask)
    return state._replace(population=operators.remove_masked(state.population, masks), mask=masks)


def _rank(cost: Float[Array, " link"]) -> Int[Array, " link"]:
    """Returns the place of each in ascending order, from 0."""
    order = jnp.argsort(cost, stable=True)
    return jnp.zeros(cost.size, jnp.int32).at[order].set(jnp.arange(cost.size, dtype=jnp.int32))
