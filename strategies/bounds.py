"""Bounds on weights, for any strategy, and for those that draw weights between them."""

from typing import Any, Literal

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.strategies import checks, draws, prefixes, vectors
from mjxwalk.strategies.base import Genotype, Population, Strategy, Tree


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


def check_bounds(lower: Tree, upper: Tree) -> None:
    """Checks two settings that are bounds; what lies between them shows with the template.

    Raises:
      ValueError: a bound is not finite, or single bounds leave nothing between them.
    """
    checks.check_numbers("lower", lower)
    checks.check_numbers("upper", upper)
    if isinstance(lower, float | int) and isinstance(upper, float | int) and not lower < upper:
        raise ValueError(f"upper must be above lower ({lower}), got {upper}")


def spread_bounds(
    lower: Tree, upper: Tree, template: Genotype
) -> tuple[Float[Array, " dim"], Float[Array, " dim"]]:
    """Returns the bounds of each weight of a template.

    Raises:
      ValueError: a bound's structure or shape does not fit the template.
    """
    return vectors.spread("lower", lower, template), vectors.spread("upper", upper, template)


def draw_between(
    key: PRNGKeyArray, num_rows: int, lower: Float[Array, " dim"], upper: Float[Array, " dim"]
) -> Float[Array, "row dim"]:
    """Returns independent numbers, uniform between bounds, in rows; uses up `key`."""
    (words,) = draws.draw_words(key, num_rows, [lower.size])
    return lower + (upper - lower) * draws.uniforms(words).astype(lower.dtype)
