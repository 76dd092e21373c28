"""LLVM IR, line by line: vector types, constants, and the names of values."""

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from mjxwalk.engines.lanes.graph import Graph
from mjxwalk.engines.lanes.scalars import is_float

FLAGS = "contract nsz"
SCALAR = {"float32": "float", "float64": "double", "bool": "i1"}


def scalar_type(dtype: str) -> str:
    """Returns LLVM's name of a scalar type."""
    return SCALAR.get(dtype) or f"i{np.dtype(dtype).itemsize * 8}"


def memory_type(dtype: str) -> str:
    """Returns LLVM's name of a scalar type in memory, where a boolean is a byte."""
    return "i8" if dtype == "bool" else scalar_type(dtype)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Target:
    """What the code is generated for.

    Attributes:
      width: lanes of a vector.
      processor: LLVM's name of the architecture.
      cpu, features: LLVM's names of the model and of what it can do.
      estimates: whether it has 14-bit estimates of 1/x and 1/sqrt(x) for this many floats.
    """

    width: int
    processor: str
    cpu: str
    features: str
    estimates: bool


class Code:
    """Lines of one function, and the names of the values that exist where they end."""

    def __init__(self, graph: Graph, target: Target) -> None:
        self.graph = graph
        self.target = target
        self.width = target.width
        self.lines: list[str] = []
        self.values: dict[int, str] = {}
        self.declared: set[str] = set()
        self.block = "entry"
        self._names: Iterator[int] = iter(range(1 << 30))

    def vector(self, dtype: str) -> str:
        """Returns LLVM's name of the vector type of a scalar type."""
        return f"<{self.width} x {scalar_type(dtype)}>"

    def let(self, expression: str) -> str:
        """Adds an instruction with a result; returns the result's name."""
        name = f"%v{next(self._names)}"
        self.lines.append(f"  {name} = {expression}")
        return name

    def do(self, instruction: str) -> None:
        """Adds an instruction without a result."""
        self.lines.append(f"  {instruction}")

    def label(self, name: str) -> None:
        """Starts a block."""
        self.lines.append(f"{name}:")
        self.block = name

    def fresh(self, stem: str) -> str:
        """Returns a name for a block that no other has."""
        return f"{stem}{next(self._names)}"

    def call(self, function: str, result: str, *args: tuple[str, str], flags: str = "") -> str:
        """Adds a call of an intrinsic; args are (type, value)."""
        self.declared.add(f"declare {result} @{function}({', '.join(t for t, _ in args)})")
        given = ", ".join(f"{t} {v}" for t, v in args)
        return self.let(f"call {flags} {result} @{function}({given})".replace("  ", " "))

    def intrinsic(self, name: str, dtype: str, *args: str) -> str:
        """Adds an LLVM intrinsic of vectors of one type."""
        vector = self.vector(dtype)
        suffix = f"v{self.width}{short_type(dtype)}"
        flags = FLAGS if is_float(dtype) else ""
        return self.call(f"llvm.{name}.{suffix}", vector, *((vector, a) for a in args), flags=flags)

    def splat(self, value: Any, dtype: str) -> str:
        """Returns a vector constant."""
        return f"splat ({scalar_type(dtype)} {literal(np.asarray(value).astype(dtype)[()])})"

    def value(self, node_id: int) -> str:
        """Returns the name of a node's value, or the constant."""
        known = self.graph.value(node_id)
        if known is not None:
            return self.splat(known, known.dtype.name)
        if node_id not in self.values:
            self.values[node_id] = self.fetch(node_id)
        return self.values[node_id]

    def fetch(self, node_id: int) -> str:
        """Returns the name of a value that was computed elsewhere."""
        raise KeyError(node_id)

    def select(self, predicate: str, on_true: str, on_false: str, dtype: str) -> str:
        """Adds a choice, lane by lane."""
        vector = self.vector(dtype)
        mask = self.vector("bool")
        return self.let(f"select {mask} {predicate}, {vector} {on_true}, {vector} {on_false}")


def short_type(dtype: str) -> str:
    """Returns LLVM's name of a scalar type within the name of an intrinsic."""
    return {"float32": "f32", "float64": "f64"}.get(dtype) or scalar_type(dtype)


def literal(value: Any) -> str:
    """Returns LLVM's text of a number."""
    dtype = value.dtype.name
    if is_float(dtype):  # LLVM writes every float with the bits of the double of equal value
        with np.errstate(invalid="ignore"):
            bits = np.asarray(value).astype(np.float64).view(np.uint64)
        return f"0x{int(bits):016X}"
    if dtype == "bool":
        return "true" if value else "false"
    return str(int(value.item()))
