"""Engines: ways to run one function of one walker for a whole population.

Each has `vmap(function, in_axes)`, which means what `jax.jit(jax.vmap(function, in_axes))` means.
`register` adds one by name.
"""

from mjxwalk.engines.protocol import Engine, Mapped
from mjxwalk.engines.registry import load, register
from mjxwalk.engines.selection import Choice, choose, prepare

__all__ = ["Choice", "Engine", "Mapped", "choose", "load", "prepare", "register"]
