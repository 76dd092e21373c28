"""Shapes and types of what functions of a user's task return: compared, and in words."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp

from mjxwalk.errors import RunError


def check_same(place: str, what: str, old: Any, new: Any, of: str) -> None:
    """Raises RunError unless two trees have the same parts, shapes and types.

    Args:
      place: of the function, for the complaint.
      what: it is called.
      old: what must come back.
      new: what came.
      of: what `old` is, in words.
    """
    if new is None and old is not None:
        raise RunError(f"{place}: {what} returns nothing; it must return {of}, as it is now")
    if jax.tree.structure(old) != jax.tree.structure(new):
        raise RunError(
            f"{place}: {what} must return the same parts as {of}, which is {shown(old)}, got "
            f"{shown(new)}"
        )
    leaves = jax.tree.leaves_with_path(old)
    for (path, one), two in zip(leaves, jax.tree.leaves(new), strict=True):
        if jnp.shape(one) != jnp.shape(two) or jnp.result_type(one) != jnp.result_type(two):
            name = jax.tree_util.keystr(path).lstrip(".")
            raise RunError(
                f"{place}: {what} changes {name or 'it'} from {shown(one)} to {shown(two)}; it "
                f"must keep the shape and the type of {of}"
            )


def shown(value: Any) -> str:
    """Returns what a value is, in a few words."""
    if hasattr(value, "shape") and hasattr(value, "dtype"):
        shape = ", ".join(map(str, value.shape))
        return f"{value.dtype}[{shape}]"
    if value is None:
        return "nothing"
    fields: Any = getattr(value, "_fields", None)
    if isinstance(value, tuple) and fields is not None:
        parts = (f"{name}: {shown(part)}" for name, part in zip(fields, value, strict=True))
        return f"{type(value).__name__}({', '.join(parts)})"
    if dataclasses.is_dataclass(value) or not isinstance(value, tuple | list | dict):
        return f"a {type(value).__name__}"
    parts = value.values() if isinstance(value, dict) else value
    return f"{type(value).__name__}({', '.join(map(shown, parts))})"
