"""Arguments of many walkers: which axis counts them, and what a kernel sees of one walker."""

from typing import Any

import jax
import numpy as np

from mjxwalk.engines.lanes.frontend import key_types
from mjxwalk.engines.lanes.ir.graph import Array
from mjxwalk.engines.lanes.ir.signature import Argument


def axes_of_leaves(in_axes: Any, args: tuple[Any, ...], kwargs: dict[str, Any]) -> list[int | None]:
    """Returns the mapped axis of every leaf; keyword arguments are mapped along their first."""
    in_axes = tuple(in_axes) if isinstance(in_axes, list) else in_axes
    if isinstance(in_axes, tuple) and len(in_axes) != len(args):
        raise ValueError(f"in_axes has {len(in_axes)} entries for {len(args)} arguments")
    prefix = (in_axes, {name: 0 for name in kwargs})
    if not isinstance(in_axes, tuple):
        prefix = (tuple(in_axes for _ in args), prefix[1])
    spread = jax.tree.broadcast(prefix, (args, kwargs), is_leaf=lambda x: x is None)
    return jax.tree.structure((args, kwargs)).flatten_up_to(spread)


def argument(leaf: Any, axis: int | None) -> Argument:
    """Returns what a kernel takes of an argument for one walker."""
    aval = jax.typeof(leaf) if not isinstance(leaf, jax.ShapeDtypeStruct) else leaf
    shape = tuple(aval.shape)
    if axis is not None:
        place = range(len(shape))[axis]
        shape = shape[:place] + shape[place + 1 :]
    if _is_keys(aval):
        kind = key_types.implementation(aval.dtype)
        return Argument((*shape, *kind.key_shape), "uint32", False, axis is None, kind.name)
    dtype = jax.dtypes.canonicalize_dtype(aval.dtype).name
    return Argument(shape, dtype, bool(getattr(aval, "weak_type", False)), axis is None)


def contiguous(leaf: Any, axis: int | None) -> Array:
    """Returns an argument as contiguous memory, the walkers' axis first."""
    array = np.asarray(jax.random.key_data(leaf) if _is_keys(leaf) else leaf)
    if axis is not None:
        array = np.moveaxis(array, range(np.ndim(leaf))[axis], 0)
    return np.ascontiguousarray(array, jax.dtypes.canonicalize_dtype(array.dtype))


def _is_keys(leaf: Any) -> bool:
    dtype = getattr(leaf, "dtype", None)
    return dtype is not None and key_types.is_key_type(dtype)


def num_walkers(leaves: list[Any], axes: list[int | None]) -> int:
    """Returns how many walkers there are."""
    mapped = [(leaf, axis) for leaf, axis in zip(leaves, axes, strict=True) if axis is not None]
    sizes = {np.shape(leaf)[axis] for leaf, axis in mapped}
    if len(sizes) != 1:
        raise ValueError(f"mapped axes must all have one size, got {sorted(sizes) or 'none'}")
    return sizes.pop()
