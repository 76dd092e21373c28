"""A small compiler from JAX functions to SIMD machine code, one lane a walker."""

from mjxwalk.engines.lanes.batching import xla_vmap
from mjxwalk.engines.lanes.errors import CannotCompileError
from mjxwalk.engines.lanes.mapping import Mapped, vmap

__all__ = ["CannotCompileError", "Mapped", "vmap", "xla_vmap"]
