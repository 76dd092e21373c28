"""Covariance matrix adaptation evolution strategy, with active recombination.

Hansen (2023), "The CMA evolution strategy: a tutorial", https://arxiv.org/abs/1604.00772 version 2,
figure 6 with the defaults of table 1; equation numbers are that version's.
"""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks, vectors
from mjxwalk.strategies.base import Genotype, Population, Strategy, Tree
from mjxwalk.strategies.evolution_paths import Paths, Rates, advance_paths, cma_rates
from mjxwalk.strategies.metrics import SearchMetrics, measure_search
from mjxwalk.strategies.operators import best_first

# ours: shortest axis over longest, near what float32 can tell from nothing.
SMALLEST_RATIO = 1e-6


class CMAESState(NamedTuple):
    """State between generations.

    Attributes:
      mean: what the population is drawn around, as one vector; see `vectors.unflatten`.
      sigma: step size.
      covariance: matrix C; a generation's covariance is sigma squared times it.
      axes: its eigenvectors, as columns; brought up to date once in a few generations.
      lengths: roots of its eigenvalues.
      paths: cumulated steps of the mean.
      template: genotype that the search started from.
      generation: number of the generation to be evaluated next.
    """

    mean: Float[Array, " dim"]
    sigma: Float[Array, ""]
    covariance: Float[Array, "dim dim"]
    axes: Float[Array, "dim dim"]
    lengths: Float[Array, " dim"]
    paths: Paths
    template: Genotype
    generation: Int[Array, ""]


class _Settings(NamedTuple):
    """Checked arguments of `cma_es`."""

    population_size: int
    sigma: Tree


def cma_es(*, population_size: int, sigma: Tree) -> Strategy[CMAESState, SearchMetrics]:
    """Returns CMA-ES of Hansen (2023), figure 6, whose other settings all follow from these.

    Its state and time grow with the square and the cube of the number of weights. Genotypes of
    equal fitness keep their order, which is that of their random draws.

    Args:
      population_size: genotypes in a generation.
      sigma: standard deviation of generation 0, in units of the weights; one value, or a pytree
        prefix of the template.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_count("population_size", population_size, minimum=2)
    checks.check_numbers("sigma", sigma, above=0.0)
    settings = _Settings(population_size, sigma)
    return Strategy(
        population_size=population_size,
        init=functools.partial(_init, settings),
        ask=functools.partial(_ask, settings),
        tell=functools.partial(_tell, settings),
    )


def _init(settings: _Settings, key: PRNGKeyArray, template: Genotype) -> CMAESState:
    del key
    checks.check_template(template)
    mean = vectors.flatten(template)
    scales = vectors.spread("sigma", settings.sigma, template)
    sigma = jnp.exp(jnp.mean(jnp.log(scales)))
    return CMAESState(
        mean=mean,
        sigma=sigma,
        covariance=jnp.diag((scales / sigma) ** 2),
        axes=jnp.eye(mean.size, dtype=mean.dtype),
        lengths=scales / sigma,
        paths=Paths(jnp.zeros_like(mean), jnp.zeros_like(mean)),
        template=jax.tree.map(jnp.asarray, template),
        generation=jnp.zeros((), jnp.int32),
    )


def _ask(
    settings: _Settings, key: PRNGKeyArray, state: CMAESState
) -> tuple[Population, CMAESState]:
    noise = vectors.standard_normals(key, settings.population_size, state.mean)
    genotypes = state.mean + state.sigma * (noise @ (state.axes * state.lengths).T)
    return vectors.unflatten_population(genotypes, state.template), state


def _tell(
    settings: _Settings,
    key: PRNGKeyArray,
    population: Population,
    fitness: Float[Array, " pop"],
    state: CMAESState,
) -> tuple[CMAESState, SearchMetrics]:
    del key
    checks.check_told(settings.population_size, population, fitness)
    rates = cma_rates(settings.population_size, state.mean.size)
    weights = jnp.asarray(rates.weights, state.mean.dtype)
    genotypes = vectors.flatten_population(population)[best_first(fitness)]
    steps = (genotypes - state.mean) / state.sigma
    step = weights[: rates.num_parents] @ steps[: rates.num_parents]
    white_step = state.axes @ ((step @ state.axes) / state.lengths)
    paths, regained, growth = advance_paths(state.paths, step, white_step, state.generation, rates)
    covariance = _update_covariance(state, steps, weights, paths.covariance, regained, rates)
    axes, lengths = _decompose_now_and_then(state, covariance, rates)
    deviations = state.sigma * jnp.sqrt(jnp.diag(state.covariance))
    new_state = state._replace(
        mean=state.mean + state.sigma * step,
        sigma=vectors.bound_sigma(state.sigma * growth),
        covariance=covariance,
        axes=axes,
        lengths=lengths,
        paths=paths,
        generation=state.generation + 1,
    )
    return new_state, measure_search(fitness, deviations)


def _update_covariance(
    state: CMAESState,
    steps: Float[Array, "pop dim"],
    weights: Float[Array, " pop"],
    path: Float[Array, " dim"],
    regained: Float[Array, ""],
    rates: Rates,
) -> Float[Array, "dim dim"]:
    """Returns the covariance matrix after a generation, equations 46 and 47."""
    # Only steps of the worse half are scaled, so only they are whitened.
    worse = steps[rates.num_parents :]
    squares = jnp.sum((worse @ state.axes / state.lengths) ** 2, axis=1)
    scale = state.mean.size / jnp.maximum(squares, jnp.finfo(steps.dtype).tiny)
    weights = weights.at[rates.num_parents :].multiply(scale)
    # A genotype that was moved to where it drew from would else count without bound.
    weights = jnp.where(jnp.isfinite(weights), weights, 0.0)
    lost = rates.rank_one + rates.rank_many * float(rates.weights.sum())
    return (
        (1 - lost + regained) * state.covariance
        + rates.rank_one * jnp.outer(path, path)
        + rates.rank_many * (steps.T @ (weights[:, None] * steps))
    )


def _decompose_now_and_then(
    state: CMAESState, covariance: Float[Array, "dim dim"], rates: Rates
) -> tuple[Float[Array, "dim dim"], Float[Array, " dim"]]:
    """Returns axes and lengths; those of before where the matrix can hardly have changed."""
    # Appendix B.2: decomposing so seldom costs no more than sampling.
    every = max(1, int(1 / (10 * state.mean.size * (rates.rank_one + rates.rank_many))))

    def decompose() -> tuple[Float[Array, "dim dim"], Float[Array, " dim"]]:
        values, axes = jnp.linalg.eigh(covariance)
        lengths = jnp.sqrt(jnp.maximum(values, 0.0))
        longest = jnp.maximum(lengths[-1], jnp.finfo(lengths.dtype).tiny)
        return axes, jnp.maximum(lengths, SMALLEST_RATIO * longest)

    if every == 1:
        return decompose()
    is_due = (state.generation + 1) % every == 0
    return jax.lax.cond(is_due, decompose, lambda: (state.axes, state.lengths))
