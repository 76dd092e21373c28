"""A small compiler from JAX functions to SIMD machine code, one lane a walker."""

from mjxwalk.engines.lanes.errors import CannotCompileError
from mjxwalk.engines.lanes.runtime.mapping import Mapped, vmap
from mjxwalk.engines.lanes.runtime.thread_pool import devices

__all__ = ["CannotCompileError", "Mapped", "devices", "vmap"]
