"""CMA-ES that starts anew with other population sizes whenever it has come to its end.

IPOP: Auger & Hansen (2005), "A restart CMA evolution strategy with increasing population size", CEC
2005, doi 10.1109/CEC.2005.1554902: every start doubles the population.
BIPOP: Hansen (2009), "Benchmarking a BI-population CMA-ES on the BBOB-2009 function testbed", GECCO
companion, doi 10.1145/1570256.1570333: besides, small populations with small steps are started
until they have had as many evaluations as the large ones.

What is asked for has the same size all the time, so that shapes never change: a generation of a
population four times as large takes four calls of `ask` and `tell`. That, and that sizes differ by
powers of two, is ours. `search_ends` tells when a search is over, `starts` what follows it.
"""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks, draws, prefixes, starts, vectors
from mjxwalk.strategies.base import Genotype, Population, Strategy, Tree
from mjxwalk.strategies.cma_es import advance as advance_full
from mjxwalk.strategies.cma_es import cma_es
from mjxwalk.strategies.evolution_paths import Rates, rates_of_start
from mjxwalk.strategies.metrics import FitnessSummary, measure_search, of_fitness
from mjxwalk.strategies.operators import best_first
from mjxwalk.strategies.search_ends import has_ended, history_length
from mjxwalk.strategies.sep_cma_es import advance as advance_separable
from mjxwalk.strategies.sep_cma_es import sep_cma_es
from mjxwalk.strategies.starts import Budget

MAX_DOUBLINGS = 5  # ours: a state that holds 32 times what is asked for is as large as seems wise


class RestartingState(NamedTuple):
    """State between calls.

    Attributes:
      inner: state of the search of this start.
      initial_sigma: step size that this start had first.
      told: genotypes told of the running generation, from the first place on.
      fitness: theirs.
      num_told: calls that these are of.
      history: best fitness of each generation, newest last; minus infinity for NaN.
      budget: of starts and calls.
    """

    inner: Any
    initial_sigma: Float[Array, ""]
    told: Float[Array, "capacity dim"]
    fitness: Float[Array, " capacity"]
    num_told: Int[Array, ""]
    history: Float[Array, " history"]
    budget: Budget


class RestartingMetrics(NamedTuple):
    """Scalars about the genotypes told, and which start they are of.

    Attributes:
      fitness: summary of their fitness.
      sigma: as of `SearchMetrics`.
      generation_size: genotypes in a generation.
      num_restarts: starts before this one.
    """

    fitness: FitnessSummary
    sigma: Float[Array, ""]
    generation_size: Int[Array, ""]
    num_restarts: Int[Array, ""]
    __getattr__ = of_fitness


class _Settings(NamedTuple):
    """Checked arguments of `ipop_cma_es` and `bipop_cma_es`."""

    search: Strategy[Any, Any]
    advance: Callable[[Any, Float[Array, "pop dim"], Rates], Any]
    start_sigma: Tree
    separable: bool
    max_doublings: int
    has_small: bool

    @property
    def capacity(self) -> int:
        """Genotypes in the largest generation."""
        return self.search.population_size << self.max_doublings


def ipop_cma_es(
    *,
    population_size: int,
    sigma: Tree,
    start_sigma: Tree = None,
    separable: bool = False,
    max_doublings: int = MAX_DOUBLINGS,
) -> Strategy[RestartingState, RestartingMetrics]:
    """Returns CMA-ES that doubles its population with every start, Auger & Hansen (2005).

    Args:
      population_size: genotypes that are asked for at a time, and in a generation of the first
        start.
      sigma: standard deviation of a start's generation 0, in units of the weights; one value, or a
        pytree prefix of the template.
      start_sigma: standard deviation of where later starts begin, about the template, likewise;
        None for `sigma`. The papers draw it from the bounds of a search, which here has none.
      separable: whether the covariance matrix is diagonal, as that of `sep_cma_es`.
      max_doublings: starts after which the population grows no more; the state grows with it.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    return _restarting(population_size, sigma, start_sigma, separable, max_doublings, False)


def bipop_cma_es(
    *,
    population_size: int,
    sigma: Tree,
    start_sigma: Tree = None,
    separable: bool = False,
    max_doublings: int = MAX_DOUBLINGS,
) -> Strategy[RestartingState, RestartingMetrics]:
    """Returns CMA-ES that starts large and small populations in turn, Hansen (2009).

    Args:
      population_size: see `ipop_cma_es`.
      sigma: see `ipop_cma_es`; a small population begins with a hundredth of it or more.
      start_sigma: see `ipop_cma_es`.
      separable: see `ipop_cma_es`.
      max_doublings: see `ipop_cma_es`.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    return _restarting(population_size, sigma, start_sigma, separable, max_doublings, True)


def _restarting(
    population_size: int,
    sigma: Tree,
    start_sigma: Tree,
    separable: bool,
    max_doublings: int,
    has_small: bool,
) -> Strategy[RestartingState, RestartingMetrics]:
    checks.check_count("max_doublings", max_doublings, minimum=0)
    start_sigma = sigma if start_sigma is None else start_sigma
    checks.check_numbers("start_sigma", start_sigma, minimum=0.0)
    make, advance = (sep_cma_es, advance_separable) if separable else (cma_es, advance_full)
    search = make(population_size=population_size, sigma=sigma)
    settings = _Settings(search, advance, start_sigma, separable, max_doublings, has_small)
    return Strategy(
        population_size=population_size,
        init=functools.partial(_init, settings),
        ask=functools.partial(_ask, settings),
        tell=functools.partial(_tell, settings),
    )


def _init(settings: _Settings, key: PRNGKeyArray, template: Genotype) -> RestartingState:
    inner = settings.search.init(key, template)
    prefixes.match_template("start_sigma", settings.start_sigma, template)
    length = history_length(settings.search.population_size, inner.mean.size)
    zero = jnp.zeros((), jnp.int32)
    return RestartingState(
        inner=inner,
        initial_sigma=inner.sigma,
        told=jnp.zeros((settings.capacity, inner.mean.size), inner.mean.dtype),
        fitness=jnp.zeros(settings.capacity, inner.mean.dtype),
        num_told=zero,
        history=jnp.full(length, -jnp.inf, inner.mean.dtype),
        budget=starts.first(),
    )


def _ask(
    settings: _Settings, key: PRNGKeyArray, state: RestartingState
) -> tuple[Population, RestartingState]:
    population, inner = settings.search.ask(key, state.inner)
    return population, state._replace(inner=inner)


def _tell(
    settings: _Settings,
    key: PRNGKeyArray,
    population: Population,
    fitness: Float[Array, " pop"],
    state: RestartingState,
) -> tuple[RestartingState, RestartingMetrics]:
    size = settings.search.population_size
    metrics = RestartingMetrics(
        *measure_search(fitness, state.inner.deviations()),
        generation_size=size << state.budget.doublings,
        num_restarts=state.budget.num_restarts,
    )
    genotypes = vectors.flatten_population(population)
    place = state.num_told * size
    state = state._replace(
        told=jax.lax.dynamic_update_slice(state.told, genotypes, (place, jnp.zeros_like(place))),
        fitness=jax.lax.dynamic_update_slice(
            state.fitness, fitness.astype(state.fitness.dtype), (place,)
        ),
        num_told=state.num_told + 1,
        budget=starts.count(state.budget),
    )
    is_whole = state.num_told == 1 << state.budget.doublings
    state = jax.lax.cond(is_whole, functools.partial(_advance, settings), lambda same: same, state)
    ends = is_whole & _has_ended(settings, state)
    return jax.lax.cond(
        ends, functools.partial(_start, settings), lambda _, same: same, key, state
    ), metrics


def _advance(settings: _Settings, state: RestartingState) -> RestartingState:
    """Returns the state after a whole generation."""
    size, inner = settings.search.population_size, state.inner
    live = jnp.arange(settings.capacity) < state.num_told * size
    # What is left from larger generations sorts behind all that was told, as NaN keeps its order.
    fitness = jnp.where(live, state.fitness, jnp.nan)
    genotypes = jnp.where(live[:, None], state.told, inner.mean)[best_first(fitness)]
    rates = rates_of_start(
        size,
        inner.mean.size,
        state.budget.doublings,
        most=settings.max_doublings,
        separable=settings.separable,
        dtype=inner.mean.dtype,
    )
    best = jnp.max(jnp.where(jnp.isnan(fitness), -jnp.inf, fitness))
    return state._replace(
        inner=settings.advance(inner, genotypes, rates),
        num_told=jnp.zeros_like(state.num_told),
        history=jnp.concatenate([state.history[1:], best[None]]),
    )


def _has_ended(settings: _Settings, state: RestartingState) -> Bool[Array, ""]:
    lengths = [
        history_length(settings.search.population_size << doubling, state.inner.mean.size)
        for doubling in range(settings.max_doublings + 1)
    ]
    length = jnp.asarray(lengths)[state.budget.doublings]
    return starts.is_over(state.budget) | has_ended(
        state.inner, state.initial_sigma, state.history, length
    )


def _start(settings: _Settings, key: PRNGKeyArray, state: RestartingState) -> RestartingState:
    """Returns the state before the first generation of the next start."""
    key_init, key_draw = jax.random.split(key)
    inner = settings.search.init(key_init, state.inner.template)
    picks, moves = draws.draw_words(key_draw, 1, [2, inner.mean.size])
    budget, factor = starts.following(
        state.budget,
        draws.uniforms(picks[0]),
        max_doublings=settings.max_doublings,
        has_small=settings.has_small,
    )
    spread = vectors.spread("start_sigma", settings.start_sigma, inner.template)
    moved = inner.mean + spread * draws.normals(moves[0]).astype(inner.mean.dtype)
    sigma = inner.sigma * factor
    return state._replace(
        inner=inner._replace(mean=moved, sigma=sigma), initial_sigma=sigma, budget=budget
    )
