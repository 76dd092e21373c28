"""Settings given per part of a genotype: one value, or a pytree that the template refines."""

from collections.abc import Callable
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

    def spread(value: Any, leaf: Array) -> Array:
        array = jnp.asarray(value, leaf.dtype if dtype is None else dtype)
        return jnp.broadcast_to(array, leaf.shape)

    return _spread(field, prefix, template, spread)


def match_links(links: Tree, template: Genotype) -> Tree:
    """Returns the number of each weight's link, as numpy arrays in the template's shapes.

    Args:
      links: one whole number, or a pytree prefix of the template as `match_template` takes; weights
        of the same number are one link, and weights of a negative number are of none.
      template: genotype whose structure and shapes are wanted.

    Returns:
      Numbers from 0 up without gaps, so that all are below the number of weights, or -1.

    Raises:
      ValueError: as `match_template`.
    """
    full = _spread("links", links, template, lambda value, leaf: np.broadcast_to(value, leaf.shape))
    leaves, structure = jax.tree.flatten(full)
    found = np.unique(np.concatenate([leaf.reshape(-1) for leaf in leaves]))
    found = found[found >= 0]
    numbers = [np.where(leaf < 0, -1, np.searchsorted(found, leaf)) for leaf in leaves]
    return jax.tree.unflatten(structure, [leaf.astype(np.int32) for leaf in numbers])


def match_present(mask: Tree, template: Genotype) -> Tree:
    """Returns a mask spread over a template, as numpy arrays of booleans in its shapes.

    Raises:
      ValueError: as `match_template`.
    """
    return _spread("mask", mask, template, lambda value, leaf: np.broadcast_to(value, leaf.shape))


def _spread(
    field: str, prefix: Tree, template: Genotype, spread: Callable[[Any, Array], Any]
) -> Tree:
    try:
        full = jax.tree.broadcast(prefix, template)
    except ValueError as error:
        raise ValueError(
            f"{field} must be one value or a pytree prefix of the template "
            f"{jax.tree.structure(template)}, got {jax.tree.structure(prefix)}"
        ) from error

    def match(path: Any, value: Any, leaf: Array) -> Any:
        try:
            return spread(value, leaf)
        except ValueError as error:
            raise ValueError(
                f"{field}{jax.tree_util.keystr(path)} must broadcast to the template's shape "
                f"{leaf.shape}, got shape {np.shape(value)}"
            ) from error

    return jax.tree.map_with_path(match, full, template)


def check_links(links: Tree) -> None:
    """Checks that a setting holds whole numbers alone.

    Raises:
      ValueError: a leaf is of another type, or there is none.
    """
    leaves: list[Any] = jax.tree.leaves(links)
    for leaf in leaves or [None]:
        if not np.issubdtype(np.asarray(leaf).dtype, np.integer):
            raise ValueError(f"links must hold whole numbers alone, got {leaf!r}")


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
