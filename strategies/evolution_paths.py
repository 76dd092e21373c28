"""Constants and cumulation that CMA-ES with a full and with a diagonal covariance matrix share.

Hansen (2023), "The CMA evolution strategy: a tutorial", https://arxiv.org/abs/1604.00772 version 2,
figure 6 and table 1; equation numbers are that version's.
"""

import math
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax.typing import DTypeLike
from jaxtyping import Array, Float, Int

from mjxwalk.strategies.base import ScalarLike


class Rates(NamedTuple):
    """The tutorial's constants for one population size and number of weights.

    They are numbers, or arrays where the population size changes as a search goes on.

    Attributes:
      weights: of the ranks, best first; the better half's sum to 1, the rest are negative.
      num_parents: only so many of them, from the first on, may be above 0.
      num_worse: only so many, from the last on, may be below 0.
      effective_parents: variance effective selection mass, mu_eff.
      sigma_decay: c_sigma.
      sigma_damping: d_sigma.
      path_decay: c_c.
      rank_one: c_1.
      rank_many: c_mu.
      expected_norm: of a vector of standard normal numbers.
    """

    weights: Float[np.ndarray, " pop"] | Float[Array, " pop"]
    num_parents: int
    num_worse: int
    effective_parents: ScalarLike
    sigma_decay: ScalarLike
    sigma_damping: ScalarLike
    path_decay: ScalarLike
    rank_one: ScalarLike
    rank_many: ScalarLike
    expected_norm: ScalarLike


def cma_rates(population_size: int, num_weights: int, *, separable: bool = False) -> Rates:
    """Returns the constants of table 1, equations 49 to 58.

    Args:
      population_size: genotypes in a generation.
      num_weights: dimensions of the search.
      separable: whether the covariance matrix is diagonal: it is then learnt (n + 2) / 3 times
        faster, Ros & Hansen (2008), "A simple modification in CMA-ES achieving linear time and
        space complexity", PPSN X, https://hal.inria.fr/inria-00287367, and from the better half
        alone.
    """
    n = num_weights
    num_parents = population_size // 2
    raw = math.log((population_size + 1) / 2) - np.log(np.arange(1, population_size + 1))
    better, worse = raw[:num_parents], raw[num_parents:]
    mass = float(better.sum() ** 2 / (better**2).sum())
    sigma_decay = (mass + 2) / (n + mass + 5)
    rank_one = 2 / ((n + 1.3) ** 2 + mass)
    rank_many = min(1 - rank_one, 2 * (0.25 + mass + 1 / mass - 2) / ((n + 2) ** 2 + mass))
    if separable:
        rank_one = min(1.0, rank_one * (n + 2) / 3)
        rank_many = min(1 - rank_one, rank_many * (n + 2) / 3)
        loss = 0.0
    else:
        # The least of equations 50 to 52: beyond it the matrix could become indefinite.
        worse_mass = float(worse.sum() ** 2 / (worse**2).sum())
        loss = min(
            1 + rank_one / rank_many,
            1 + 2 * worse_mass / (mass + 2),
            (1 - rank_one - rank_many) / (n * rank_many),
        )
    weights = np.concatenate([better / better.sum(), loss * worse / -worse.sum()])
    return Rates(
        weights=weights,
        num_parents=num_parents,
        num_worse=population_size - num_parents,
        effective_parents=mass,
        sigma_decay=sigma_decay,
        sigma_damping=1 + 2 * max(0.0, math.sqrt((mass - 1) / (n + 1)) - 1) + sigma_decay,
        path_decay=(4 + mass / n) / (n + 4 + 2 * mass / n),
        rank_one=rank_one,
        rank_many=rank_many,
        expected_norm=math.sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n**2)),
    )


def rates_of_start(
    population_size: int,
    num_weights: int,
    doublings: Int[Array, ""],
    *,
    most: int,
    separable: bool,
    dtype: DTypeLike = float,
) -> Rates:
    """Returns the constants of a generation, whose weights are 0 behind its last genotype.

    Args:
      population_size: of the first start.
      num_weights: dimensions of the search.
      doublings: of the population since.
      most: how many doublings there can be.
      separable: whether the covariance matrix is diagonal.
      dtype: of the search.
    """
    capacity = population_size << most
    rows: list[Rates] = []
    for doubling in range(most + 1):
        size = population_size << doubling
        rates = cma_rates(size, num_weights, separable=separable)
        weights = np.zeros(capacity)
        weights[:size] = rates.weights
        rows.append(rates._replace(weights=weights))
    fields = {
        name: jnp.asarray(np.stack([getattr(row, name) for row in rows]), dtype)[doublings]
        for name in Rates._fields
        if not name.startswith("num_")
    }
    return Rates(num_parents=capacity, num_worse=capacity, **fields)


class Paths(NamedTuple):
    """Cumulated steps of the mean.

    Attributes:
      sigma: p_sigma, steps as if the covariance matrix were the identity.
      covariance: p_c, in units of the step size.
    """

    sigma: Float[Array, " dim"]
    covariance: Float[Array, " dim"]


def advance_paths(
    paths: Paths,
    step: Float[Array, " dim"],
    white_step: Float[Array, " dim"],
    generation: Int[Array, ""],
    rates: Rates,
) -> tuple[Paths, Float[Array, ""], Float[Array, ""]]:
    """Returns the paths one step further, what the old covariance regains, and the step's growth.

    Args:
      paths: before.
      step: of the mean, over the step size; <y>_w.
      white_step: the same times the covariance matrix to the power -1/2.
      generation: generations told before this one.
      rates: constants.

    Returns:
      Paths, equations 43 and 45; the share that the covariance matrix keeps more of, since its
      path stood still because that of the step size is long, (1 - h_sigma) of equation 47; and the
      factor on the step size, equation 44.
    """
    keep = 1 - rates.sigma_decay
    push = jnp.sqrt(rates.sigma_decay * (2 - rates.sigma_decay) * rates.effective_parents)
    sigma = keep * paths.sigma + push * white_step
    length = jnp.sqrt(jnp.sum(sigma**2))
    # The path starts at nothing and is this share of its final length after so many generations.
    warm = jnp.sqrt(1 - jnp.power(keep, 2 * (generation + 1.0)))
    stalls = length >= (1.4 + 2 / (step.size + 1)) * rates.expected_norm * warm
    push = jnp.sqrt(rates.path_decay * (2 - rates.path_decay) * rates.effective_parents)
    covariance = (1 - rates.path_decay) * paths.covariance + jnp.where(stalls, 0.0, push * step)
    growth = rates.sigma_decay / rates.sigma_damping * (length / rates.expected_norm - 1)
    # pycma bounds it likewise, against the length of a first step far outside.
    regained = jnp.where(stalls, rates.rank_one * rates.path_decay * (2 - rates.path_decay), 0.0)
    return Paths(sigma, covariance), regained, jnp.exp(jnp.minimum(growth, 1.0))
