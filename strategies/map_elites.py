"""MAP-Elites: the fittest genotype for each cell of a grid of behaviours.

Mouret & Clune (2015), "Illuminating search spaces by mapping elites",
https://arxiv.org/abs/1504.04909, figure 2. Offspring come by the iso+line operator of Vassiliades &
Mouret (2018), "Discovering the elite hypervolume by leveraging interspecies correlation",
https://arxiv.org/abs/1804.03906, equation 1.
"""

import dataclasses
import functools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol, runtime_checkable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks, draws, edge, vectors
from mjxwalk.strategies.base import Ask, Genotype, Init, Population, ScalarLike
from mjxwalk.strategies.metrics import FitnessSummary, of_fitness, summarise_fitness

ISO_SIGMA = 0.01  # Vassiliades & Mouret (2018), section 4.2, sigma_1
LINE_SIGMA = 0.2  # sigma_2 there


class MapElitesState(NamedTuple):
    """The archive.

    Attributes:
      genotypes: of each cell, as vectors; the template where a cell is empty.
      fitness: of each cell; minus infinity where it is empty.
      template: genotype that the search started from.
      generation: number of the generation to be evaluated next.
    """

    genotypes: Float[Array, "cell dim"]
    fitness: Float[Array, " cell"]
    template: Genotype
    generation: Int[Array, ""]


class MapElitesMetrics(NamedTuple):
    """Scalars about the generation told, and the archive after it.

    Attributes:
      fitness: summary of the generation's fitness.
      num_filled: cells that hold a genotype.
      archive_fitness: highest in the archive.
    """

    fitness: FitnessSummary
    num_filled: Int[Array, ""]
    archive_fitness: Float[Array, ""]
    __getattr__ = of_fitness


@runtime_checkable
class TellBehaviour(Protocol):
    """Takes fitness and behaviour in and makes the next state."""

    def __call__(
        self,
        key: PRNGKeyArray,
        population: Population,
        fitness: Any,
        behaviour: Any,
        state: MapElitesState,
        /,
    ) -> tuple[MapElitesState, MapElitesMetrics]:
        """Returns the next state; a genotype whose fitness or behaviour is NaN gets no cell.

        Args:
          key: random key.
          population: genotypes from `ask`, in the same order.
          fitness: one value a genotype, higher is better.
          behaviour: where on the grid each genotype is; outside counts as the outermost cell.
          state: state from `ask`.
        """
        ...


@dataclasses.dataclass(frozen=True, kw_only=True)
class MapElites:
    """Quality-diversity search: fills an archive with the fittest genotype of each behaviour.

    It is no `Strategy`, as fitness alone tells it nothing: each genotype needs the description of
    its behaviour too.

    Attributes:
      population_size: genotypes evaluated at a time.
      init: makes the empty archive.
      ask: gives the population to evaluate.
      tell_behaviour: puts a population into the archive, by fitness and behaviour.
    """

    population_size: int
    init: Init[MapElitesState]
    ask: Ask[MapElitesState]
    tell_behaviour: TellBehaviour


def map_elites(
    *,
    population_size: int,
    initial_sigma: ScalarLike,
    lower: Sequence[float],
    upper: Sequence[float],
    num_bins: Sequence[int],
    iso_sigma: ScalarLike = ISO_SIGMA,
    line_sigma: ScalarLike = LINE_SIGMA,
) -> MapElites:
    """Returns MAP-Elites, Mouret & Clune (2015), on a grid.

    Args:
      population_size: genotypes evaluated at a time.
      initial_sigma: standard deviation about the template of genotypes drawn while the archive is
        empty.
      lower: end of the grid on each axis of behaviour, in the behaviour's units.
      upper: the other end.
      num_bins: cells along each axis.
      iso_sigma: standard deviation of the noise on an offspring.
      line_sigma: standard deviation of its place on the line through its parents, in units of their
        distance.

    Raises:
      ValueError: a setting is out of its range, or the grid's sequences differ in length.
    """
    checks.check_count("population_size", population_size, minimum=2)
    for name, value in (
        ("initial_sigma", initial_sigma),
        ("iso_sigma", iso_sigma),
        ("line_sigma", line_sigma),
    ):
        checks.check_numbers(name, value, minimum=0.0)
    _check_grid(lower, upper, num_bins)

    def init(key: PRNGKeyArray, template: Genotype) -> MapElitesState:
        del key
        start = vectors.flatten(template)
        num_cells = math.prod(num_bins)
        return MapElitesState(
            genotypes=jnp.broadcast_to(start, (num_cells, start.size)),
            fitness=jnp.full(num_cells, -jnp.inf, float),
            template=template,
            generation=jnp.zeros((), jnp.int32),
        )

    def ask(key: PRNGKeyArray, state: MapElitesState) -> tuple[Population, MapElitesState]:
        dim = state.genotypes.shape[1]
        picks, moves = draws.draw_words(key, population_size, [2, dim + 1])
        noise = draws.normals(moves).astype(state.genotypes.dtype)
        first, second = pick_filled(state.fitness, draws.uniforms(picks))
        along = line_sigma * noise[:, :1] * (state.genotypes[second] - state.genotypes[first])
        is_empty = ~jnp.any(state.fitness > -jnp.inf)
        sigma = jnp.where(is_empty, initial_sigma, iso_sigma)
        offspring = state.genotypes[first] + along + sigma * noise[:, 1:]
        return vectors.unflatten_population(offspring, state.template), state

    def tell_behaviour(
        key: PRNGKeyArray,
        population: Any,
        fitness: Any,
        behaviour: Any,
        state: MapElitesState,
    ) -> tuple[MapElitesState, MapElitesMetrics]:
        key, population, fitness = edge.told(
            jax.jit(ask), population_size, key, population, fitness, state
        )
        behaviour = edge.as_floats("behaviour", behaviour)
        if behaviour.shape != (population_size, len(num_bins)):
            raise ValueError(
                f"behaviour must have shape ({population_size}, {len(num_bins)}), "
                f"got {behaviour.shape}"
            )
        cells = find_cells(behaviour, jnp.asarray(lower), jnp.asarray(upper), tuple(num_bins))
        genotypes, best = insert(
            state, vectors.flatten_population(population), fitness, cells, behaviour
        )
        filled = best > -jnp.inf
        metrics = MapElitesMetrics(
            summarise_fitness(fitness),
            num_filled=jnp.sum(filled, dtype=jnp.int32),
            archive_fitness=jnp.max(best),
        )
        new_state = state._replace(
            genotypes=genotypes, fitness=best, generation=state.generation + 1
        )
        return new_state, metrics

    return MapElites(
        population_size=population_size,
        init=functools.partial(edge.init, init),
        ask=functools.partial(edge.ask, ask),
        tell_behaviour=tell_behaviour,
    )


def find_cells(
    behaviour: Float[Array, "pop axis"],
    lower: Float[Array, " axis"],
    upper: Float[Array, " axis"],
    num_bins: tuple[int, ...],
) -> Int[Array, " pop"]:
    """Returns each behaviour's cell, counted in row-major order; NaN gives an arbitrary one."""
    share = (behaviour - lower) / (upper - lower)
    sizes = jnp.asarray(num_bins)
    # Bounded before the cast, in which what does not fit an integer is undefined.
    place = jnp.clip(jnp.nan_to_num(share), 0.0, 1.0) * sizes
    index = jnp.minimum(place.astype(jnp.int32), sizes - 1)
    return jnp.ravel_multi_index(tuple(index.T), num_bins, mode="clip").astype(jnp.int32)


def insert(
    state: MapElitesState,
    genotypes: Float[Array, "pop dim"],
    fitness: Float[Array, " pop"],
    cells: Int[Array, " pop"],
    behaviour: Float[Array, "pop axis"],
) -> tuple[Float[Array, "cell dim"], Float[Array, " cell"]]:
    """Returns the archive's genotypes and fitness with each cell's fittest put in.

    Who was first stays where two are equal.
    """
    num_cells, size = state.fitness.shape[0], fitness.shape[0]
    is_known = ~jnp.isnan(fitness) & ~jnp.any(jnp.isnan(behaviour), axis=1)
    value = jnp.where(is_known, fitness, -jnp.inf).astype(state.fitness.dtype)
    best = jax.ops.segment_max(value, cells, num_cells)
    wins = value == best[cells]
    winner = jax.ops.segment_min(jnp.where(wins, jnp.arange(size), size), cells, num_cells)
    better = best > state.fitness
    new = genotypes[jnp.minimum(winner, size - 1)]
    return (
        jnp.where(better[:, None], new, state.genotypes),
        jnp.where(better, best, state.fitness),
    )


def pick_filled(
    fitness: Float[Array, " cell"], draws: Float[Array, "pop 2"]
) -> tuple[Int[Array, " pop"], Int[Array, " pop"]]:
    """Returns pairs of filled cells, all equally likely; any cell if none is filled.

    Args:
      fitness: of the cells; minus infinity where one is empty.
      draws: uniform in [0, 1).
    """
    count = jnp.cumsum(fitness > -jnp.inf)
    wanted = jnp.floor(draws * count[-1]).astype(count.dtype)
    places = jnp.searchsorted(count, wanted, side="right")
    first, second = jnp.minimum(places, fitness.shape[0] - 1).astype(jnp.int32).T
    return first, second


def _check_grid(lower: Sequence[float], upper: Sequence[float], num_bins: Sequence[int]) -> None:
    if not len(lower) == len(upper) == len(num_bins) > 0:
        raise ValueError(
            "lower, upper and num_bins must have one value for each axis of behaviour, "
            f"got {len(lower)}, {len(upper)} and {len(num_bins)}"
        )
    for low, high, bins in zip(lower, upper, num_bins, strict=True):
        checks.check_numbers("lower", low)
        checks.check_numbers("upper", high)
        if not low < high:
            raise ValueError(f"upper must be above lower ({low}), got {high}")
        checks.check_count("num_bins", bins, minimum=1)
