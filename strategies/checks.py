"""Checks of settings and static shapes, shared by all strategies.

Values that are being traced, as in a `vmap` over hyper-parameters, are unknown and pass unchecked.
"""

import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Float

from mjxwalk.strategies.base import Genotype, Population


def check_count(field: str, value: Any, *, minimum: int, maximum: int | None = None) -> None:
    """Checks that a setting is a whole number in a closed range.

    Raises:
      ValueError: it is not; the message names the field, the range and the value.
    """
    is_whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not is_whole or value < minimum or (maximum is not None and value > maximum):
        limit = f">= {minimum}" if maximum is None else f"in [{minimum}, {maximum}]"
        raise ValueError(f"{field} must be a whole number {limit}, got {value!r}")


def check_even(field: str, value: Any) -> None:
    """Checks that a setting is an even number of at least 2, as mirrored sampling needs.

    Raises:
      ValueError: it is not; the message names the field and the value.
    """
    check_count(field, value, minimum=2)
    if value % 2:
        raise ValueError(f"{field} must be an even number >= 2, as noise is mirrored, got {value}")


def check_numbers(
    field: str,
    values: Any,
    *,
    minimum: float = -math.inf,
    above: float = -math.inf,
    maximum: float = math.inf,
) -> None:
    """Checks every leaf of a setting that is a number or a pytree of numbers.

    Args:
      field: name of the setting.
      values: number, array or pytree of them.
      minimum: smallest value allowed.
      above: value that all must exceed.
      maximum: largest value allowed.

    Raises:
      ValueError: a leaf is not numeric or holds a value outside the range or not finite.
    """
    leaves: list[Any] = jax.tree.leaves(values)
    limits = [(">=", minimum), (">", above), ("<=", maximum)]
    limit = " and ".join(f"{sign} {bound}" for sign, bound in limits if math.isfinite(bound))
    wanted = f"{field} must be finite and {limit}" if limit else f"{field} must be finite"
    if not leaves:
        raise ValueError(f"{wanted}, got {values!r}")
    for leaf in leaves:
        if isinstance(leaf, Tracer):
            continue
        numbers = np.asarray(leaf)
        if numbers.dtype == bool or not np.can_cast(numbers.dtype, np.float64, "same_kind"):
            raise ValueError(f"{wanted}, got {leaf!r}")
        allowed = np.isfinite(numbers) & (numbers >= minimum)
        allowed &= (numbers > above) & (numbers <= maximum)
        if not allowed.all():
            raise ValueError(f"{wanted}, got {numbers[~allowed].flat[0]}")


def check_template(template: Genotype) -> None:
    """Checks that a template is a pytree of float arrays with at least one weight.

    Raises:
      ValueError: a leaf is not a float array, or there is no weight.
    """
    for path, leaf in jax.tree.leaves_with_path(template):
        dtype = getattr(leaf, "dtype", None)
        if dtype is None or not jnp.issubdtype(dtype, jnp.floating):
            found = type(leaf).__name__ if dtype is None else dtype
            raise ValueError(
                f"template{jax.tree_util.keystr(path)} must be an array of floats, got {found}"
            )
    if not sum(leaf.size for leaf in jax.tree.leaves(template)):
        raise ValueError("template must hold at least one weight, got none")


def check_told(population_size: int, population: Population, fitness: Float[Array, " pop"]) -> None:
    """Checks the shapes that `tell` was given.

    Raises:
      ValueError: fitness or a leaf of the population does not have the population's length.
    """
    if fitness.shape != (population_size,):
        raise ValueError(f"fitness must have shape ({population_size},), got {fitness.shape}")
    for path, leaf in jax.tree.leaves_with_path(population):
        if leaf.shape[:1] != (population_size,):
            raise ValueError(
                f"population{jax.tree_util.keystr(path)} must have a first axis of "
                f"{population_size}, got shape {leaf.shape}"
            )
