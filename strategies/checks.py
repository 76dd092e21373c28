"""Checks of settings, shared by all strategies.

Values that are being traced, as in a `vmap` over hyper-parameters, are unknown and pass unchecked.
"""

import math
from typing import Any

import jax
import numpy as np
from jax.core import Tracer


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
