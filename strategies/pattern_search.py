"""Generalised pattern search: polls along both directions of every axis on a mesh that adapts.

Torczon (1997), "On the convergence of pattern search algorithms", SIAM Journal on Optimization
7(1):1-25, doi 10.1137/S1052623493250780, with the basis of 2N directions and the expansion and
contraction of MATLAB's `patternsearch`.

A generation is a batch of polls about a centre, numbered on from the batch before. Poll n goes
along direction n modulo 2N at the mesh size times `contraction` to the power of n div 2N: with each
2N polls that failed the mesh is finer, and a large population tries finer meshes at once. The best
poll that beats the centre becomes it, the mesh it was found on times `expansion` is the new mesh
size, and polls are numbered from 0 again.
"""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks, draws, operators, prefixes
from mjxwalk.strategies.base import Genotype, Population, Strategy, Tree
from mjxwalk.strategies.metrics import FitnessSummary, of_fitness, summarise_fitness

INITIAL_MESH = 1.0  # MATLAB's default, as the next two
EXPANSION = 2.0
CONTRACTION = 0.5
SMALLEST_MESH = 1e-6  # MATLAB's MeshTolerance
LARGEST_MESH = 1e6  # ours: a slope without end would otherwise lead to infinity


class PatternSearchState(NamedTuple):
    """State between generations.

    Attributes:
      centre: fittest genotype so far; the template before the first `tell`.
      best_fitness: of the centre; minus infinity as long as nothing better is known.
      mesh: size at poll 0, in units of `scale`.
      poll: number of the next; minus one stands for the centre itself.
      order: directions in the order in which they are polled.
      generation: told so far.
      finished: whether the mesh has become smaller than its limit.
    """

    centre: Genotype
    best_fitness: Float[Array, ""]
    mesh: Float[Array, ""]
    poll: Int[Array, ""]
    order: Int[Array, " direction"]
    generation: Int[Array, ""]
    finished: Bool[Array, ""]


class PatternSearchMetrics(NamedTuple):
    """Scalars about the generation told.

    Attributes:
      fitness: summary of the generation's fitness.
      mesh: of its first poll.
    """

    fitness: FitnessSummary
    mesh: Float[Array, ""]
    __getattr__ = of_fitness


class _Settings(NamedTuple):
    """Checked arguments of `pattern_search`."""

    population_size: int
    scale: Tree
    initial_mesh: float
    expansion: float
    contraction: float
    smallest_mesh: float
    lower: Tree
    upper: Tree


def pattern_search(
    *,
    population_size: int,
    scale: Tree = 1.0,
    initial_mesh: float | int = INITIAL_MESH,
    expansion: float | int = EXPANSION,
    contraction: float | int = CONTRACTION,
    smallest_mesh: float | int = SMALLEST_MESH,
    lower: Tree = None,
    upper: Tree = None,
) -> Strategy[PatternSearchState, PatternSearchMetrics]:
    """Returns the pattern search, which starts at the template.

    `scale`, `lower` and `upper` are one value for all weights, or a pytree prefix of the template
    whose leaves broadcast to the template's.

    Args:
      population_size: polls in a generation.
      scale: of each weight: a mesh size of 1 moves it by so much.
      initial_mesh: size of the first mesh.
      expansion: factor on the mesh after a poll that was better; 1 at least.
      contraction: factor after polls along all directions that were not; below 1.
      smallest_mesh: a mesh smaller than that ends the search, and stays as it is.
      lower: smallest value of each weight, where polls stop; None for none.
      upper: largest value; None for none.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_count("population_size", population_size, minimum=2)
    checks.check_numbers("scale", scale, above=0.0)
    checks.check_numbers("smallest_mesh", smallest_mesh, above=0.0)
    checks.check_numbers("initial_mesh", initial_mesh, minimum=smallest_mesh, maximum=LARGEST_MESH)
    checks.check_numbers("expansion", expansion, minimum=1.0)
    checks.check_numbers("contraction", contraction, above=0.0, maximum=0.99)
    for name, bound in (("lower", lower), ("upper", upper)):
        if bound is not None:
            checks.check_numbers(name, bound)
    settings = _Settings(
        population_size=population_size,
        scale=scale,
        initial_mesh=float(initial_mesh),
        expansion=float(expansion),
        contraction=float(contraction),
        smallest_mesh=float(smallest_mesh),
        lower=lower,
        upper=upper,
    )
    return Strategy(
        population_size=population_size,
        init=functools.partial(_init, settings),
        ask=functools.partial(_ask, settings),
        tell=functools.partial(_tell, settings),
    )


def poll_offset(
    poll: Int[Array, ""],
    order: Int[Array, " direction"],
    scale: Float[Array, " dim"],
    contraction: float | Float[Array, ""],
) -> tuple[Float[Array, " dim"], Float[Array, ""]]:
    """Returns where a poll lies about the centre on a mesh of size 1, and the size of its own mesh.

    Args:
      poll: number of the poll; minus one is the centre itself.
      order: of the 2N directions; direction d is axis d div 2, forward where d is even.
      scale: of each weight.
      contraction: of the mesh after 2N polls.
    """
    num = order.shape[0]
    direction = order[poll % num]
    mesh = jnp.asarray(contraction, scale.dtype) ** (jnp.maximum(poll, 0) // num)
    sign = jnp.where(poll < 0, 0, 1 - 2 * (direction % 2)).astype(scale.dtype)
    axis = jnp.arange(scale.shape[0]) == direction // 2
    return jnp.where(axis, sign * mesh * scale, 0.0), mesh


def _init(settings: _Settings, key: PRNGKeyArray, template: Genotype) -> PatternSearchState:
    _spread(settings, template)  # to refuse what does not fit before anything is evaluated
    flat, _ = ravel_pytree(template)
    dtype = flat.dtype
    return PatternSearchState(
        centre=template,
        best_fitness=jnp.full((), -jnp.inf, float),
        mesh=jnp.asarray(settings.initial_mesh, dtype),
        poll=jnp.asarray(-1, jnp.int32),
        order=_shuffled(key, 2 * flat.size),
        generation=jnp.zeros((), jnp.int32),
        finished=jnp.zeros((), bool),
    )


def _ask(
    settings: _Settings, key: PRNGKeyArray, state: PatternSearchState
) -> tuple[Population, PatternSearchState]:
    del key
    centre, unflatten = ravel_pytree(state.centre)
    scale, lower, upper = _spread(settings, state.centre)
    polls = state.poll + jnp.arange(settings.population_size, dtype=jnp.int32)
    offsets, _ = jax.vmap(poll_offset, (0, None, None, None))(
        polls, state.order, scale, settings.contraction
    )
    polled = jnp.clip(centre + state.mesh * offsets, lower, upper)
    return jax.vmap(unflatten)(polled), state


def _tell(
    settings: _Settings,
    key: PRNGKeyArray,
    population: Population,
    fitness: Float[Array, " pop"],
    state: PatternSearchState,
) -> tuple[PatternSearchState, PatternSearchMetrics]:
    num = state.order.shape[0]
    place = operators.best_first(fitness)[0]
    best = fitness[place].astype(state.best_fitness.dtype)
    is_better = best > state.best_fitness  # False for NaN
    found_at = state.poll + place.astype(jnp.int32)
    # The centre itself, as it is evaluated first, is no move, and the rest of its batch has failed.
    moved = is_better & (found_at >= 0)
    contraction = jnp.asarray(settings.contraction, state.mesh.dtype)
    level = jnp.maximum(found_at, 0) // num
    expanded = state.mesh * contraction**level * jnp.asarray(settings.expansion, state.mesh.dtype)
    next_poll = state.poll + settings.population_size
    failed = jnp.maximum(next_poll, 0) // num
    mesh = jnp.where(moved, expanded, state.mesh * contraction**failed)
    new_state = PatternSearchState(
        centre=operators.choose(is_better, operators.take(population, place), state.centre),
        best_fitness=jnp.where(is_better, best, state.best_fitness),
        mesh=jnp.clip(mesh, settings.smallest_mesh, LARGEST_MESH),
        poll=jnp.where(moved, 0, next_poll - failed * num).astype(jnp.int32),
        order=jnp.where(moved, _shuffled(key, num), state.order),
        generation=state.generation + 1,
        finished=mesh < settings.smallest_mesh,
    )
    return new_state, PatternSearchMetrics(summarise_fitness(fitness), mesh=state.mesh)


def _shuffled(key: PRNGKeyArray, num: int) -> Int[Array, " direction"]:
    [words] = draws.draw_words(key, 1, [num])
    return jnp.argsort(words[0]).astype(jnp.int32)


def _spread(
    settings: _Settings, template: Genotype
) -> tuple[Float[Array, " dim"], Float[Array, " dim"], Float[Array, " dim"]]:
    """Returns scale and bounds of each weight."""
    lower = -jnp.inf if settings.lower is None else settings.lower
    upper = jnp.inf if settings.upper is None else settings.upper
    named = (("scale", settings.scale), ("lower", lower), ("upper", upper))
    parts = [prefixes.match_template(name, value, template) for name, value in named]
    scale, low, high = (ravel_pytree(part)[0] for part in parts)
    return scale, low, high
