"""The text of one LLVM function in which every value is a plain number: that of a single walker."""

from typing import Any

import numpy as np

from mjxwalk.engines.lanes.backend.target import Target
from mjxwalk.engines.lanes.backend.types import literal, memory_type, scalar_type, short_type
from mjxwalk.engines.lanes.backend.writer import FLAGS, Writer
from mjxwalk.engines.lanes.ir.semantics import is_float


class ScalarWriter(Writer):
    """Appends instructions on plain numbers; its target has vectors of width 1.

    Attributes:
      pointer: LLVM's type of a pointer to an argument, an output or a table.
    """

    def __init__(self, target: Target, pointer: str) -> None:
        super().__init__(target)
        self.pointer = pointer

    def vector(self, dtype: str) -> str:
        """Returns LLVM's name of a scalar type."""
        return scalar_type(dtype)

    def intrinsic(self, name: str, dtype: str, *args: str) -> str:
        """Adds an LLVM intrinsic of numbers of one type."""
        kind = scalar_type(dtype)
        flags = FLAGS if is_float(dtype) else ""
        function = f"llvm.{name}.{short_type(dtype)}"
        return self.call(function, kind, *((kind, arg) for arg in args), flags=flags)

    def splat(self, value: Any, dtype: str) -> str:
        """Returns a constant."""
        return literal(np.asarray(value).astype(dtype)[()])

    def load(self, pointer: str, array: str, place: str, dtype: str) -> str:
        """Returns array[place]; `pointer` is LLVM's type of the array's pointer."""
        kind = memory_type(dtype)
        address = self.let(f"getelementptr {kind}, {pointer} {array}, i64 {place}")
        value = self.let(f"load {kind}, {pointer} {address}")
        return self.let(f"trunc i8 {value} to i1") if dtype == "bool" else value

    def store(self, pointer: str, array: str, place: str, dtype: str, value: str) -> None:
        """Writes array[place]."""
        kind = memory_type(dtype)
        if dtype == "bool":
            value = self.let(f"zext i1 {value} to i8")
        address = self.let(f"getelementptr {kind}, {pointer} {array}, i64 {place}")
        self.do(f"store {kind} {value}, {pointer} {address}")
