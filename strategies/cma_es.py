"""Covariance matrix adaptation evolution strategy, with active recombination.

Hansen (2023), "The CMA evolution strategy: a tutorial", https://arxiv.org/abs/1604.00772 version 2,
figure 6 with the defaults of table 1; equation numbers are that version's.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from mjxwalk.strategies import vectors
from mjxwalk.strategies.base import Genotype, Strategy, Tree
from mjxwalk.strategies.covariance_adaptation import cma_search
from mjxwalk.strategies.evolution_paths import Paths, Rates, advance_paths
from mjxwalk.strategies.metrics import SearchMetrics

# ours: shortest axis over longest, near what float32 can tell from nothing.
SMALLEST_RATIO = 1e-6
# ours: with so many weights a decomposition takes several times as long as a series of products.
MANY_WEIGHTS = 100
# ours: the largest change of the covariance for which that series, of five terms, is exact to 1e-4.
SMALL_CHANGE = 0.2


class CMAESState(NamedTuple):
    """State between generations.

    Attributes:
      mean: what the population is drawn around, as one vector; see `vectors.unflatten`.
      sigma: step size.
      covariance: matrix C; a generation's covariance is sigma squared times it.
      root: a matrix that times its own transpose is C; brought up to date once in a few
        generations.
      whitener: its inverse.
      paths: cumulated steps of the mean.
      template: genotype that the search started from.
      generation: number of the generation to be evaluated next.
    """

    mean: Float[Array, " dim"]
    sigma: Float[Array, ""]
    covariance: Float[Array, "dim dim"]
    root: Float[Array, "dim dim"]
    whitener: Float[Array, "dim dim"]
    paths: Paths
    template: Genotype
    generation: Int[Array, ""]

    def deviations(self) -> Float[Array, " dim"]:
        """Returns the standard deviation of each weight."""
        return self.sigma * jnp.sqrt(jnp.diag(self.covariance))

    def draw(self, noise: Float[Array, "pop dim"]) -> Float[Array, "pop dim"]:
        """Returns the genotypes that standard normal numbers stand for."""
        return self.mean + self.sigma * (noise @ self.root.T)


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
    return cma_search(
        _start, advance, population_size=population_size, sigma=sigma, separable=False
    )


def _start(
    template: Genotype, sigma: Float[Array, ""], deviations: Float[Array, " dim"]
) -> CMAESState:
    mean = vectors.flatten(template)
    return CMAESState(
        mean=mean,
        sigma=sigma,
        covariance=jnp.diag((deviations / sigma) ** 2),
        root=jnp.diag(deviations / sigma),
        whitener=jnp.diag(sigma / deviations),
        paths=Paths(jnp.zeros_like(mean), jnp.zeros_like(mean)),
        template=template,
        generation=jnp.zeros((), jnp.int32),
    )


def advance(state: CMAESState, ordered: Float[Array, "pop dim"], rates: Rates) -> CMAESState:
    """Returns the state after a generation, of which all genotypes are given, best first."""
    weights = jnp.maximum(jnp.asarray(rates.weights[: rates.num_parents], state.mean.dtype), 0)
    steps = (ordered - state.mean) / state.sigma
    step = weights @ steps[: rates.num_parents]
    paths, regained, growth = advance_paths(
        state.paths, step, state.whitener @ step, state.generation, rates
    )
    covariance = _update_covariance(state, steps, paths.covariance, regained, rates)
    root, whitener = _decompose_now_and_then(state, covariance, rates)
    return state._replace(
        mean=state.mean + state.sigma * step,
        sigma=vectors.bound_sigma(state.sigma * growth),
        covariance=covariance,
        root=root,
        whitener=whitener,
        paths=paths,
        generation=state.generation + 1,
    )


def _update_covariance(
    state: CMAESState,
    steps: Float[Array, "pop dim"],
    path: Float[Array, " dim"],
    regained: Float[Array, ""],
    rates: Rates,
) -> Float[Array, "dim dim"]:
    """Returns the covariance matrix after a generation, equations 46 and 47."""
    weights = jnp.asarray(rates.weights, steps.dtype)
    first = steps.shape[0] - rates.num_worse
    # Only steps of the worse half are scaled, so only they are whitened.
    squares = jnp.sum((steps[first:] @ state.whitener.T) ** 2, axis=1)
    scale = state.mean.size / jnp.maximum(squares, jnp.finfo(steps.dtype).tiny)
    weights = weights.at[first:].multiply(jnp.where(weights[first:] < 0, scale, 1.0))
    # A genotype that was moved to where it drew from would else count without bound.
    weights = jnp.where(jnp.isfinite(weights), weights, 0.0)
    lost = rates.rank_one + rates.rank_many * rates.weights.sum()
    kept = jnp.asarray(1 - lost + regained, steps.dtype)
    return (
        kept * state.covariance
        + rates.rank_one * jnp.outer(path, path)
        + rates.rank_many * (steps.T @ (weights[:, None] * steps))
    )


def _decompose_now_and_then(
    state: CMAESState, covariance: Float[Array, "dim dim"], rates: Rates
) -> tuple[Float[Array, "dim dim"], Float[Array, "dim dim"]]:
    """Returns root and whitener; those of before where the matrix can hardly have changed."""
    # Appendix B.2: decomposing so seldom costs no more than sampling.
    every = 1 / (10 * state.mean.size * (rates.rank_one + rates.rank_many))

    def go_on() -> tuple[Float[Array, "dim dim"], Float[Array, "dim dim"]]:
        if state.mean.size < MANY_WEIGHTS:
            return decompose(covariance)
        return follow(state.whitener, covariance)

    if isinstance(every, float) and every < 2:
        return go_on()
    is_due = (state.generation + 1) % jnp.maximum(jnp.int32(every), 1) == 0
    return jax.lax.cond(is_due, go_on, lambda: (state.root, state.whitener))


def decompose(
    covariance: Float[Array, "dim dim"],
) -> tuple[Float[Array, "dim dim"], Float[Array, "dim dim"]]:
    """Returns the symmetric root of a covariance matrix, and its inverse."""
    values, axes = jnp.linalg.eigh(covariance)
    lengths = jnp.sqrt(jnp.maximum(values, 0.0))
    longest = jnp.maximum(lengths[-1], jnp.finfo(lengths.dtype).tiny)
    lengths = jnp.maximum(lengths, SMALLEST_RATIO * longest)
    return (axes * lengths) @ axes.T, (axes / lengths) @ axes.T


def follow(
    whitener: Float[Array, "dim dim"], covariance: Float[Array, "dim dim"]
) -> tuple[Float[Array, "dim dim"], Float[Array, "dim dim"]]:
    """Returns a root of a covariance matrix and its inverse, from the inverse of one of before.

    Ours: where the tutorial decomposes the matrix into its eigenvectors, a root of before, W^-1,
    becomes W^-1 (I + F)^(1/2), with the change F = W C W^T - I. It is a root as good as any to draw
    with, and whitens the path of the step size in axes that turn no more than they must. Errors do
    not add up, as F is what W really lacks. A change that is not small is decomposed.
    """
    change = whitener @ covariance @ whitener.T - jnp.eye(whitener.shape[0], dtype=whitener.dtype)
    is_small = jnp.max(jnp.sum(jnp.abs(change), axis=1)) < SMALL_CHANGE

    def expand() -> tuple[Float[Array, "dim dim"], Float[Array, "dim dim"]]:
        # (I + F)^(-1/2) W, of which the root's inverse follows by C W^T.
        square = change @ change
        one = jnp.eye(change.shape[0], dtype=change.dtype)
        rest = square @ (3 / 8 * one - 5 / 16 * change + 35 / 128 * square)
        new = (one - change / 2 + rest) @ whitener
        return covariance @ new.T, new

    return jax.lax.cond(is_small, expand, lambda: decompose(covariance))
