"""Which population size a search starts with next, and with which steps: IPOP and BIPOP.

Auger & Hansen (2005) and Hansen (2009), see `restarting_cma_es`; where they differ, BIPOP is that
of `fmin` in pycma 4.5, https://github.com/CMA-ES/pycma.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

SMALLEST_SIGMA_FACTOR = 0.01  # pycma 4.5: of a small population's first step size
SMALL_SHARE = 0.5  # pycma 4.5: a small population's evaluations, over those of all large ones


class Budget(NamedTuple):
    """Which start a search is at, and what the starts have taken.

    Attributes:
      doublings: base-2 logarithm of this start's population, in calls.
      most_doublings: the same of the largest so far.
      is_small: whether it counts as one of a small population.
      calls: taken by this start.
      small_calls: taken by all starts of small populations, of which the first is one.
      large_calls: taken by all of large ones.
      num_restarts: starts before this one.
    """

    doublings: Int[Array, ""]
    most_doublings: Int[Array, ""]
    is_small: Bool[Array, ""]
    calls: Int[Array, ""]
    small_calls: Int[Array, ""]
    large_calls: Int[Array, ""]
    num_restarts: Int[Array, ""]


def first() -> Budget:
    """Returns the budget before the first call."""
    zero = jnp.zeros((), jnp.int32)
    # pycma 4.5 too counts the first start as one of a small population.
    return Budget(zero, zero, jnp.ones((), bool), zero, zero, zero, zero)


def count(budget: Budget) -> Budget:
    """Returns the budget after another call."""
    return budget._replace(
        calls=budget.calls + 1,
        small_calls=budget.small_calls + budget.is_small,
        large_calls=budget.large_calls + ~budget.is_small,
    )


def is_over(budget: Budget) -> Bool[Array, ""]:
    """Returns whether a start of a small population has had its share."""
    has_share = budget.is_small & (budget.num_restarts > 0)
    return has_share & (budget.calls >= SMALL_SHARE * budget.large_calls)


def following(
    budget: Budget, uniform: Float[Array, "2"], *, max_doublings: int, has_small: bool
) -> tuple[Budget, Float[Array, ""]]:
    """Returns the budget of the next start, and the factor on its first step size.

    Args:
      budget: at the end of a start.
      uniform: in [0, 1), for the size and the steps of a small population.
      max_doublings: of the largest population.
      has_small: whether there are small populations, as BIPOP has.
    """
    is_small = (budget.small_calls < budget.large_calls) & has_small
    larger = jnp.minimum(budget.most_doublings + 1, max_doublings)
    most = jnp.where(is_small, budget.most_doublings, larger)
    # pycma 4.5 has 2^(most u^2) and rounds that down; to a power of two is ours.
    fewer = jnp.floor(most * uniform[0] ** 2).astype(most.dtype)
    after = budget._replace(
        doublings=jnp.where(is_small, fewer, most),
        most_doublings=most,
        is_small=is_small,
        calls=jnp.zeros_like(budget.calls),
        num_restarts=budget.num_restarts + 1,
    )
    return after, jnp.where(is_small, SMALLEST_SIGMA_FACTOR ** uniform[1], 1.0)
