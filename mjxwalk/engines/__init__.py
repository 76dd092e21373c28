"""Engines: ways to run one function of one walker for a whole population.

Each has `vmap(fn, in_axes)`, which means what `jax.jit(jax.vmap(fn, in_axes))` means.
"""

from mjxwalk.engines.selection import ENGINES, Choice, choose, prepare

__all__ = ["ENGINES", "Choice", "choose", "prepare"]
