"""When a search by CMA-ES has come to its end, so that only another start can find more.

The criteria, and their numbers, are those of pycma 4.5, https://github.com/CMA-ES/pycma, without
its "stagnation" and its limits on time.
"""

import math

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from mjxwalk.strategies.base import ScalarLike
from mjxwalk.strategies.cma_es import CMAESState
from mjxwalk.strategies.sep_cma_es import SepCMAESState

# All from pycma 4.5.
FLAT = 1e-12  # tolfunhist
SMALL = 1e-11  # tolx; there of weights whose scale is 1, here of the first step size
NO_EFFECT_COORDINATE = 0.2  # standard deviations
NO_EFFECT_AXIS = 0.1  # standard deviations
CONDITION = 1e14  # tolconditioncov

Search = CMAESState | SepCMAESState


def history_length(population_size: int, num_weights: int) -> int:
    """Returns for how many generations the best fitness must not change to be flat."""
    return 10 + math.ceil(30 * num_weights / population_size)


def has_ended(
    state: Search,
    initial_sigma: Float[Array, ""],
    history: Float[Array, " generation"],
    length: Int[Array, ""],
) -> Bool[Array, ""]:
    """Returns whether a search has come to its end.

    Args:
      state: after `tell`.
      initial_sigma: step size that it started with.
      history: best fitness of each generation, newest last.
      length: how many of these count.
    """
    counts = jnp.arange(history.size) >= history.size - length
    is_old = state.generation >= length
    return (
        (is_old & _is_flat(history, counts)) | _cannot_move(state) | _is_small(state, initial_sigma)
    )


def _is_flat(
    history: Float[Array, " generation"], counts: Bool[Array, " generation"]
) -> Bool[Array, ""]:
    """Returns whether what counts is all the same, NaN and infinite too."""
    lowest = jnp.min(jnp.where(counts, history, jnp.inf))
    highest = jnp.max(jnp.where(counts, history, -jnp.inf))
    # A difference of infinities is NaN.
    return (lowest == highest) | (highest - lowest < FLAT)


def _cannot_move(state: Search) -> Bool[Array, ""]:
    """Returns whether a step is lost in the mean's last digit, or the axes differ too much."""
    one = state.deviations()
    lost = jnp.any(state.mean + NO_EFFECT_COORDINATE * one == state.mean)
    if isinstance(state, SepCMAESState):
        return lost | (jnp.max(state.lengths) > CONDITION**0.5 * jnp.min(state.lengths))
    # ours: a column of the root where pycma has a principal axis, and a bound of the condition.
    axis = state.sigma * state.root[:, state.generation % state.mean.size]
    lost |= jnp.all(state.mean + NO_EFFECT_AXIS * axis == state.mean)
    return lost | (_norm(state.root) * _norm(state.whitener) > CONDITION**0.5)


def _is_small(state: Search, initial_sigma: ScalarLike) -> Bool[Array, ""]:
    """Returns whether all standard deviations, and the path, are far below the first step size."""
    limit = SMALL * initial_sigma
    path = state.sigma * jnp.abs(state.paths.covariance)
    return jnp.all(jnp.maximum(state.deviations(), path) < limit)


def _norm(matrix: Float[Array, "dim dim"]) -> Float[Array, ""]:
    return jnp.sqrt(jnp.sum(matrix**2))
