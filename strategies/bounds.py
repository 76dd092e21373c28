"""Bounds on weights, for any strategy."""

from typing import Any, Literal

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.strategies import prefixes
from mjxwalk.strategies.base import Genotype, Population, Strategy, Tree
from mjxwalk.strategies.two_point_ga import check_bounds


def with_bounds(
    strategy: Strategy[Any, Any],
    *,
    lower: Tree,
    upper: Tree,
    how: Literal["clip", "reflect"] = "clip",
) -> Strategy[Any, Any]:
    """Returns the strategy with all genotypes that it hands out between bounds.

    It is told the genotypes as they were evaluated, and so learns from what the bounds made of its
    own. A distribution's mean may lie outside. The state is the strategy's own.

    Args:
      strategy: any.
      lower: smallest value of each weight; one value, or a pytree prefix of the template.
      upper: largest value, likewise.
      how: "clip" moves a weight outside to the bound, "reflect" as far inside as it was outside.

    Raises:
      ValueError: a bound is not finite or they leave nothing between them, `how` is neither of the
        two, or, from `ask`, a bound does not fit the template.
    """
    check_bounds(lower, upper)
    if how not in ("clip", "reflect"):
        raise ValueError(f"how must be clip or reflect, got {how!r}")
    bring_in = clip if how == "clip" else reflect

    def ask(key: PRNGKeyArray, state: Any) -> tuple[Population, Any]:
        population, state = strategy.ask(key, state)
        one: Genotype = jax.tree.map(lambda leaf: leaf[0], population)
        low = prefixes.match_template("lower", lower, one)
        high = prefixes.match_template("upper", upper, one)
        return jax.tree.map(bring_in, population, low, high), state

    return Strategy(
        population_size=strategy.population_size, init=strategy.init, ask=ask, tell=strategy.tell
    )


def clip(
    value: Float[Array, "..."], lower: Float[Array, "..."], upper: Float[Array, "..."]
) -> Float[Array, "..."]:
    """Returns values with those outside moved to the bound."""
    return jnp.clip(value, lower, upper)


def reflect(
    value: Float[Array, "..."], lower: Float[Array, "..."], upper: Float[Array, "..."]
) -> Float[Array, "..."]:
    """Returns values folded back at the bounds, as often as it takes."""
    width = upper - lower
    # A triangle wave of two widths; clipped because its last bit may stick out.
    phase = jnp.mod(value - lower, 2 * width)
    return jnp.clip(lower + width - jnp.abs(phase - width), lower, upper)
