"""Exponential natural evolution strategy: a full covariance matrix, moved by its natural gradient.

Wierstra, Schaul, Glasmachers, Sun, Peters & Schmidhuber (2014), "Natural evolution strategies",
JMLR 15:949-980, https://jmlr.org/papers/v15/wierstra14a.html, algorithm 5; defaults of table 1.
"""

import functools
import math
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from mjxwalk.strategies import checks, vectors
from mjxwalk.strategies.base import Genotype, ScalarLike, Strategy, Tree
from mjxwalk.strategies.metrics import SearchMetrics
from mjxwalk.strategies.normal_search import normal_search
from mjxwalk.strategies.ranks import nes_utilities
from mjxwalk.strategies.snes import MEAN_LEARNING_RATE, default_sigma_learning_rate


class XNESState(NamedTuple):
    """State between generations; a genotype is mean + sigma times axes times standard normals.

    Attributes:
      mean: what the population is drawn around, as one vector; see `vectors.unflatten`.
      sigma: step size.
      axes: the paper's B, whose determinant stays what it was.
      template: genotype that the search started from.
      generation: number of the generation to be evaluated next.
    """

    mean: Float[Array, " dim"]
    sigma: Float[Array, ""]
    axes: Float[Array, "dim dim"]
    template: Genotype
    generation: Int[Array, ""]


def xnes(
    *,
    population_size: int,
    sigma: Tree,
    mean_learning_rate: ScalarLike = MEAN_LEARNING_RATE,
    sigma_learning_rate: ScalarLike | None = None,
    axes_learning_rate: ScalarLike | None = None,
) -> Strategy[XNESState, SearchMetrics]:
    """Returns the exponential natural evolution strategy of Wierstra et al. (2014), algorithm 5.

    Its state and time grow with the square and the cube of the number of weights.

    Args:
      population_size: genotypes in a generation.
      sigma: standard deviation of generation 0, in units of the weights; one value, or a pytree
        prefix of the template.
      mean_learning_rate: share of the natural gradient that the mean follows.
      sigma_learning_rate: the same of the step size; None for `default_learning_rate`.
      axes_learning_rate: the same of the axes; None for `default_learning_rate`.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_numbers("mean_learning_rate", mean_learning_rate, above=0.0)
    if sigma_learning_rate is not None:
        checks.check_numbers("sigma_learning_rate", sigma_learning_rate, minimum=0.0)
    if axes_learning_rate is not None:
        checks.check_numbers("axes_learning_rate", axes_learning_rate, minimum=0.0)
    return normal_search(
        population_size=population_size,
        sigma=sigma,
        init=_init,
        deviations=_deviations,
        tell=functools.partial(_tell, mean_learning_rate, sigma_learning_rate, axes_learning_rate),
        draw=lambda state, noise: state.mean + state.sigma * (noise @ state.axes.T),
    )


def default_learning_rate(num_weights: int, population_size: int) -> float:
    """Returns the learning rate of step size and axes.

    Up to the population of table 1 in Wierstra et al. (2014), 4 + 3 ln n, it is the table's. ours:
    beyond, it grows in proportion, as noise of the gradient falls, up to the table's for separable
    search, which adapts as many variances as there are weights.
    """
    table = (9 + 3 * math.log(num_weights)) / (5 * num_weights * math.sqrt(num_weights))
    usual = 4 + int(3 * math.log(num_weights))
    separable = default_sigma_learning_rate(num_weights)
    return min(table * max(1.0, population_size / usual), max(table, separable))


def symmetric_exponential(matrix: Float[Array, "dim dim"]) -> Float[Array, "dim dim"]:
    """Returns the exponential of a symmetric matrix."""
    values, basis = jnp.linalg.eigh(matrix)
    return (basis * jnp.exp(values)) @ basis.T


def _init(template: Genotype, deviations: Float[Array, " dim"]) -> XNESState:
    sigma = jnp.exp(jnp.mean(jnp.log(deviations)))
    return XNESState(
        mean=vectors.flatten(template),
        sigma=sigma,
        axes=jnp.diag(deviations / sigma),
        template=template,
        generation=jnp.zeros((), jnp.int32),
    )


def _deviations(state: XNESState) -> Float[Array, " dim"]:
    return state.sigma * jnp.sqrt(jnp.sum(state.axes**2, axis=1))


def _tell(
    mean_learning_rate: ScalarLike,
    sigma_learning_rate: ScalarLike | None,
    axes_learning_rate: ScalarLike | None,
    genotypes: Float[Array, "pop dim"],
    fitness: Float[Array, " pop"],
    state: XNESState,
) -> XNESState:
    size = state.mean.size
    usual = default_learning_rate(size, fitness.size)
    rates = (sigma_learning_rate, axes_learning_rate)
    for_sigma, for_axes = (usual if rate is None else rate for rate in rates)
    utilities = nes_utilities(fitness).astype(state.mean.dtype)
    steps = (genotypes - state.mean) / state.sigma

    # The paper sums over the noise z = inverse(B) steps; to sum over the steps and invert the sum
    # is the same, at a price that does not grow with the population.
    scatter = steps.T @ (utilities[:, None] * steps)
    half = jnp.linalg.solve(state.axes, scatter)
    noise_scatter = jnp.linalg.solve(state.axes, half.T)
    # The paper's gradient of M; utilities sum to zero, and so the identity drops out of it.
    gradient = (noise_scatter + noise_scatter.T) / 2
    growth = jnp.trace(gradient) / size
    shape = gradient - growth * jnp.eye(size, dtype=gradient.dtype)
    return state._replace(
        mean=state.mean + mean_learning_rate * state.sigma * (utilities @ steps),
        sigma=vectors.bound_sigma(state.sigma * jnp.exp(for_sigma / 2 * growth)),
        axes=state.axes @ symmetric_exponential(for_axes / 2 * shape),
        generation=state.generation + 1,
    )
