"""Settings given per part of a genotype: one value, or a pytree that the template refines."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.typing import DTypeLike
from jaxtyping import Array

from mjxwalk.strategies.base import Genotype, Tree


def match_template(
    field: str, prefix: Tree, template: Genotype, dtype: DTypeLike | None = None
) -> Tree:
    """Returns a setting spread over a template: one array of the same shape for each leaf.

    Args:
      field: name of the setting, for the error message.
      prefix: one value, or a pytree prefix of the template; each of its leaves is a scalar or an
        array that broadcasts to every template leaf below it.
      template: genotype whose structure and shapes are wanted.
      dtype: dtype of the result; None for the dtype of the template's leaf.

    Raises:
      ValueError: the structure is no prefix of the template's, or a shape does not broadcast.
    """
    try:
        full = jax.tree.broadcast(prefix, template)
    except ValueError as error:
        raise ValueError(
            f"{field} must be one value or a pytree prefix of the template "
            f"{jax.tree.structure(template)}, got {jax.tree.structure(prefix)}"
        ) from error

    def match(path: Any, value: Any, leaf: Array) -> Array:
        array = jnp.asarray(value, leaf.dtype if dtype is None else dtype)
        try:
            return jnp.broadcast_to(array, leaf.shape)
        except ValueError as error:
            raise ValueError(
                f"{field}{jax.tree_util.keystr(path)} must broadcast to the template's shape "
                f"{leaf.shape}, got shape {np.shape(value)}"
            ) from error

    return jax.tree.map_with_path(match, full, template)


def check_mask(mask: Tree) -> None:
    """Checks that a setting holds booleans alone.

    Raises:
      ValueError: a leaf is of another type.
    """
    for leaf in jax.tree.leaves(mask):
        if np.asarray(leaf).dtype != bool:
            raise ValueError(f"mask must hold True or False alone, got {leaf!r}")


def count_groups(groups: Tree) -> int:
    """Returns how many groups there are.

    Raises:
      ValueError: the groups are not the whole numbers from 0 up without gaps.
    """
    leaves = [np.asarray(leaf).reshape(-1) for leaf in jax.tree.leaves(groups)]
    found = np.unique(np.concatenate(leaves)) if leaves else np.zeros(0)
    is_whole = np.issubdtype(found.dtype, np.integer)
    if not is_whole or not np.array_equal(found, np.arange(found.size)):
        raise ValueError(
            f"groups must use every whole number from 0 to the largest, got {found.tolist()}"
        )
    return found.size
