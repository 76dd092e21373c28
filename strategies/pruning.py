"""Pruning: an evolution goes on while every individual loses a link now and then.

Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient 2D and 3D bipedal
walking over rough terrain", Adaptive Behavior 21(1), doi 10.1177/1059712312462904, section 2.7.5.

Every tenth generation each individual except the elite loses a random link. Masks are each
individual's own and recombine, so that selection decides which losses stay. Once the median fitness
of the latest elites falls below a share of what it was before, nothing more is removed, and the
evolution goes on for a while to make the best of the links that are left.

That is for individuals that carry masks, as those of `self_adaptive_ga`. Around any other strategy
masks evolve as a population of their own, see `evolving_masks`.
"""

import dataclasses
from typing import Any, NamedTuple, Protocol, TypeAlias, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks
from mjxwalk.strategies.base import Genotype, IntTree, Population, Strategy, Tree
from mjxwalk.strategies.evolving_masks import carry, one_of, with_evolving_masks
from mjxwalk.strategies.links import count_links, prune_population
from mjxwalk.strategies.metrics import FitnessSummary, of_fitness, summarise_fitness
from mjxwalk.strategies.operators import Individual
from mjxwalk.strategies.prefixes import check_links, match_links
from mjxwalk.strategies.self_adaptive_ga import NUM_ELITES

# All from Solomon et al. (2013), section 2.7.5.
EVERY = 10  # generations
FLOOR = 0.9  # share of the reference
REFERENCE = 50  # elites
WINDOW = 10  # elites
SETTLE = 200  # generations

Series: TypeAlias = Float[Array, " generation"] | Float[np.ndarray, " generation"]


class PruningState(NamedTuple):
    """State of a strategy that prunes.

    Attributes:
      inner: the strategy's own state if that carries masks, else an `EvolvingMasksState`.
      reference: fitness of the last elites before pruning, newest last; NaN where there was none.
      recent: fitness of the latest elites of all, newest last.
      age: generations told since pruning began; negative while the reference is still gathered.
      stopped_at: age at which removing ended; -1 before.
      finished: whether the generations after that are over too.
      num_pruned: links removed from the population that is being evaluated, of all individuals.
    """

    inner: Any
    reference: Float[Array, " reference"]
    recent: Float[Array, " window"]
    age: Int[Array, ""]
    stopped_at: Int[Array, ""]
    finished: Bool[Array, ""]
    num_pruned: Int[Array, ""]


class PruningMetrics(NamedTuple):
    """Scalars about the generation told, and what pruning did to it.

    Attributes:
      fitness: summary of the generation's fitness.
      mean_learning_rate: as of `SelfAdaptiveGAMetrics`; None around other strategies.
      mean_num_links: links that an individual has, of those that can be removed.
      num_pruned: links that all individuals together lost before they were evaluated.
    """

    fitness: FitnessSummary
    mean_learning_rate: Float[Array, ""] | None
    mean_num_links: Float[Array, ""]
    num_pruned: Int[Array, ""]
    __getattr__ = of_fitness


@runtime_checkable
class Begin(Protocol):
    """Makes the state at which pruning of a population that has evolved begins."""

    def __call__(self, state: Any, elite_fitness: Series, /) -> PruningState:
        """Returns the state before the first generation that is pruned.

        Args:
          state: of the wrapped strategy, after `tell`.
          elite_fitness: of the best of each of the last generations, newest last. If there are
            fewer than the reference takes, so many generations are evolved unpruned before.
        """
        ...


@dataclasses.dataclass(frozen=True, kw_only=True)
class PruningStrategy(Strategy[PruningState, PruningMetrics]):
    """A strategy that prunes; `init` starts at generation 0 and `begin` in an evolved population.

    Attributes:
      begin: makes the state at which pruning begins.
    """

    begin: Begin


class _Settings(NamedTuple):
    """Checked arguments of `with_pruning`."""

    strategy: Strategy[Any, Any]
    links: Tree
    num_elites: int
    every: int
    floor: float
    reference: int
    window: int
    settle: int


def with_pruning(
    strategy: Strategy[Any, Any],
    *,
    links: Tree,
    num_elites: int = NUM_ELITES,
    every: int = EVERY,
    floor: float = FLOOR,
    reference: int = REFERENCE,
    window: int = WINDOW,
    settle: int = SETTLE,
) -> PruningStrategy:
    """Returns the strategy over weights and masks, pruned as Solomon et al. (2013), section 2.7.5.

    What pruning means depends on the strategy:
    - One whose state carries masks, as `self_adaptive_ga`'s does: each individual but the elite
      loses a link of its own, and its offspring inherit the loss with its weights. The paper's.
    - Any other: each genotype that is handed out has the mask of its place, and masks evolve beside
      the strategy, see `evolving_masks`. Of one that searches with a distribution, or by polls
      around a point, the distribution or the point has all links; of a genetic algorithm the
      offspring have masks of the best, yet not those of their own parents.

    Fitness has to be positive for a share of it to be a loss. A strategy whose links run out
    without such a loss is never finished.

    Args:
      strategy: any; `self_adaptive_ga` with `links` as here, so that all weights of a link
        recombine together.
      links: number of the link that each weight belongs to, negative for weights that stay for
        good; one value for all weights, or a pytree prefix of the template. Weights of the same
        number are removed together.
      num_elites: individuals at the front of a population that are copies of the last one's best.
      every: generations from one removal to the next; the first is at once.
      floor: share of the median fitness of the elites before pruning; removing ends when that of
        the latest elites is below.
      reference: number of elites before pruning that count.
      window: number of latest elites that count.
      settle: generations after removing has ended until the strategy is finished.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, `begin` or `ask`, does not fit.
    """
    checks.check_count("num_elites", num_elites, minimum=0, maximum=strategy.population_size)
    checks.check_count("every", every, minimum=1)
    checks.check_numbers("floor", floor, minimum=0.0)
    checks.check_count("reference", reference, minimum=1)
    checks.check_count("window", window, minimum=1, maximum=reference)
    checks.check_count("settle", settle, minimum=0)
    check_links(links)
    masked = with_evolving_masks(strategy, links=links, num_elites=num_elites)
    settings = _Settings(masked, links, num_elites, every, floor, reference, window, settle)

    def init(key: PRNGKeyArray, template: Genotype) -> PruningState:
        return begin(strategy.init(key, template), jnp.zeros(0, float))

    def begin(state: Any, elite_fitness: Series) -> PruningState:
        return _begin(settings, carry(strategy, state), elite_fitness)

    def ask(key: PRNGKeyArray, state: PruningState) -> tuple[Population, PruningState]:
        return _ask(settings, key, state)

    def tell(
        key: PRNGKeyArray,
        population: Population,
        fitness: Float[Array, " pop"],
        state: PruningState,
    ) -> tuple[PruningState, PruningMetrics]:
        return _tell(settings, key, population, fitness, state)

    return PruningStrategy(
        population_size=strategy.population_size, init=init, begin=begin, ask=ask, tell=tell
    )


def has_declined(
    recent: Float[Array, " window"], reference: Float[Array, " reference"], floor: float
) -> Bool[Array, ""]:
    """Returns whether the median of the latest fitness is below a share of the reference's."""
    return jnp.median(recent) < floor * jnp.median(reference)


def _begin(settings: _Settings, state: Any, elite_fitness: Series) -> PruningState:
    match_links(settings.links, one_of(state.population))  # to refuse what does not fit
    known = _nan_is_worst(jnp.asarray(elite_fitness)[-settings.reference :])
    missing = settings.reference - known.size
    series = jnp.concatenate([jnp.full(missing, jnp.nan, float), known.astype(float)])
    return PruningState(
        inner=state,
        reference=series,
        recent=series[-settings.window :],
        age=jnp.full((), -missing, jnp.int32),
        stopped_at=jnp.full((), -1, jnp.int32),
        finished=jnp.zeros((), bool),
        num_pruned=jnp.zeros((), jnp.int32),
    )


def _ask(
    settings: _Settings, key: PRNGKeyArray, state: PruningState
) -> tuple[Population, PruningState]:
    key_ask, key_prune = jax.random.split(key)
    population, inner = settings.strategy.ask(key_ask, state.inner)
    links = _links(settings, state)
    before = Individual(population, inner.mask)
    elite = jnp.arange(settings.strategy.population_size) < settings.num_elites
    is_due = (state.age >= 0) & (state.stopped_at < 0) & (state.age % settings.every == 0)

    def prune(key: PRNGKeyArray) -> tuple[Individual, Int[Array, " pop"]]:
        after = prune_population(key, before, links, elite)
        return after, _num_links(before.mask, links) - _num_links(after.mask, links)

    nobody = jnp.zeros(elite.size, jnp.int32)
    after, num_lost = jax.lax.cond(is_due, prune, lambda key: (before, nobody), key_prune)
    inner = inner._replace(population=after.genotype, mask=after.mask)
    return after.genotype, state._replace(inner=inner, num_pruned=jnp.sum(num_lost))


def _tell(
    settings: _Settings,
    key: PRNGKeyArray,
    population: Population,
    fitness: Float[Array, " pop"],
    state: PruningState,
) -> tuple[PruningState, PruningMetrics]:
    inner, metrics = settings.strategy.tell(key, population, fitness, state.inner)
    elite = jnp.max(_nan_is_worst(fitness))
    prunes = state.age >= 0
    reference = jnp.where(prunes, state.reference, _push(state.reference, elite))
    recent = _push(state.recent, elite)
    age = state.age + 1
    stops = prunes & (state.stopped_at < 0) & has_declined(recent, reference, settings.floor)
    stopped_at = jnp.where(stops, age, state.stopped_at)
    new_state = PruningState(
        inner=inner,
        reference=reference,
        recent=recent,
        age=age,
        stopped_at=stopped_at,
        finished=(stopped_at >= 0) & (age - stopped_at >= settings.settle),
        num_pruned=jnp.zeros((), jnp.int32),
    )
    num_links = jnp.mean(_num_links(state.inner.mask, _links(settings, state)).astype(float))
    rate = getattr(metrics, "mean_learning_rate", None)
    return new_state, PruningMetrics(summarise_fitness(fitness), rate, num_links, state.num_pruned)


def _links(settings: _Settings, state: PruningState) -> IntTree:
    return jax.tree.map(jnp.asarray, match_links(settings.links, one_of(state.inner.population)))


def _num_links(masks: Tree, links: IntTree) -> Int[Array, " pop"]:
    return jax.vmap(count_links, in_axes=(0, None))(masks, links)


def _nan_is_worst(fitness: Float[Array, " any"]) -> Float[Array, " any"]:
    return jnp.where(jnp.isnan(fitness), -jnp.inf, fitness)


def _push(series: Float[Array, " time"], value: Float[Array, ""]) -> Float[Array, " time"]:
    """Returns the series one place further, with a value at its end."""
    return jnp.concatenate([series[1:], value[None].astype(series.dtype)])
