"""Pytrees to flat tables of named arrays and back."""

from collections.abc import Mapping
from typing import Any

import jax
import numpy as np
import numpy.typing as npt

from mjxwalk.errors import RunError


def flatten(tree: Any) -> dict[str, npt.NDArray[Any]]:
    """Returns the tree's leaves in host memory, named by their path: names joined by dots."""
    leaves, _ = jax.tree.flatten_with_path(tree)
    return {_name(path): np.asarray(leaf) for path, leaf in leaves}


def unflatten(template: Any, arrays: Mapping[str, npt.NDArray[Any]]) -> Any:
    """Returns a tree of the template's structure from named arrays.

    Args:
      template: a tree whose leaves have the shapes and dtypes to come.
      arrays: by the names that `flatten` gives.

    Raises:
      RunError: a name is missing or too many, or an array has another shape or dtype.
    """
    leaves, structure = jax.tree.flatten_with_path(template)
    arrays = {name: np.asarray(array) for name, array in arrays.items()}
    wanted = {_name(path): leaf for path, leaf in leaves}
    for name in arrays:
        if name not in wanted:
            raise RunError(f"{name} has no place in this experiment")
    for name, leaf in wanted.items():
        if name not in arrays:
            raise RunError(f"{name} is missing")
        if arrays[name].shape != leaf.shape or arrays[name].dtype != leaf.dtype:
            raise RunError(
                f"{name} must be {leaf.dtype}{list(leaf.shape)}, "
                f"got {arrays[name].dtype}{list(arrays[name].shape)}"
            )
    return jax.tree.unflatten(structure, [arrays[name] for name in wanted])


def _name(path: Any) -> str:
    # A tree that is one array has an empty path.
    return jax.tree_util.keystr(path, simple=True, separator=".") or "value"
