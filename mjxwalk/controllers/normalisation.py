"""Normalised senses: policies see each sense less its mean, over its standard deviation.

Both come from all that populations have sensed so far: version 2 of augmented random search, Mania,
Guy & Recht (2018), https://arxiv.org/abs/1803.07055, and Salimans et al. (2017),
https://arxiv.org/abs/1703.03864. A genotype carries them beside its weights, so that whatever is
done with a walker later, it sees as it saw when it evolved; strategies leave them alone. A trial
counts sums, which the evolution adds up between generations (`mjxwalk.evolution.sensed`).
"""

from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

SMALLEST_DEVIATION = 1e-4  # ours: what varies less, as a sensor at rest, is not blown up


class Statistics(NamedTuple):
    """What is known of the senses.

    Attributes:
      num: how often they were read.
      mean: of each.
      deviation: standard deviation of each.
    """

    num: Float[Array, "*pop"]
    mean: Float[Array, "*pop input"]
    deviation: Float[Array, "*pop input"]


class Normalised(NamedTuple):
    """A genotype whose policy sees normalised senses.

    Attributes:
      weights: of the policy.
      senses: as they were known when the walker was evaluated.
    """

    weights: Any
    senses: Statistics


class Sums(NamedTuple):
    """What a trial counts, of each sense less its mean so far.

    Attributes:
      num: how often the senses were read.
      total: sum.
      squares: sum of squares.
    """

    num: Float[Array, "*batch"]
    total: Float[Array, "*batch input"]
    squares: Float[Array, "*batch input"]

    def add(self, away: Float[Array, " input"], counts: Bool[Array, ""]) -> "Sums":
        """Returns the sums with one reading more, less its mean, if it counts."""
        share = counts.astype(away.dtype)
        away = share * away
        return Sums(self.num + share, self.total + away, self.squares + away * away)


def nothing_known(num: int) -> Statistics:
    """Returns what is known of so many senses before they were read; they are seen as they are."""
    return Statistics(jnp.zeros(()), jnp.zeros(num), jnp.zeros(num))


def nothing_counted(num: int) -> Sums:
    """Returns the sums of so many senses at the start of a trial."""
    return Sums(jnp.zeros(()), jnp.zeros(num), jnp.zeros(num))


def normalise(
    senses: Statistics, away: Float[Array, " input"], limit: float
) -> Float[Array, " input"]:
    """Returns senses less their means over their deviations, cut to so many deviations."""
    return jnp.clip(away / divisors(senses), -limit, limit)


def divisors(senses: Statistics) -> Float[Array, " input"]:
    """Returns the deviation of each sense, 1 of those that hardly vary."""
    deviation = jnp.asarray(senses.deviation)
    return jnp.where(deviation > SMALLEST_DEVIATION, deviation, 1.0)
