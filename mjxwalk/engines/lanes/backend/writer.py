"""The text of one LLVM function, instruction by instruction; every value is a vector of lanes."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from mjxwalk.engines.lanes.backend.target import Target
from mjxwalk.engines.lanes.backend.types import literal, scalar_type, short_type
from mjxwalk.engines.lanes.ir.semantics import is_float

FLAGS = "contract nsz"
Index = Sequence[str]  # of a number of an array, an i64 for each axis


class Writer:
    """Appends instructions; knows LLVM and the target, and nothing of graphs.

    Attributes:
      lines: what has been written.
      declared: declarations of the intrinsics that the lines call.
      block: name of the block that is being written.
      bits: type of an integer with a bit for each lane.
    """

    def __init__(self, target: Target) -> None:
        self.target = target
        self.width = target.width
        self.bits = f"i{target.width}"
        self.lines: list[str] = []
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

    def select(self, predicate: str, on_true: str, on_false: str, dtype: str) -> str:
        """Adds a choice, lane by lane."""
        vector, mask = self.vector(dtype), self.vector("bool")
        return self.let(f"select {mask} {predicate}, {vector} {on_true}, {vector} {on_false}")

    def mask_of(self, bits: str) -> str:
        """Returns bits as a vector of booleans."""
        return self.let(f"bitcast {self.bits} {bits} to {self.vector('bool')}")

    def bits_of(self, mask: str) -> str:
        """Returns a vector of booleans as bits."""
        return self.let(f"bitcast {self.vector('bool')} {mask} to {self.bits}")

    def any(self, bits: str) -> str:
        """Returns whether any of the bits is set."""
        return self.let(f"icmp ne {self.bits} {bits}, 0")

    def without(self, bits: str, others: str) -> str:
        """Returns the bits that are set, but for the others."""
        return self.let(f"and {self.bits} {bits}, {self.inverted(others)}")

    def inverted(self, bits: str) -> str:
        """Returns the bits that are not set."""
        return self.let(f"xor {self.bits} {bits}, -1")

    def either(self, x: str, y: str) -> str:
        """Returns x or y, single bits."""
        return self.let(f"or i1 {x}, {y}")

    def fresh(self, stem: str) -> str:
        """Returns a name for a block that no other has."""
        return f"{stem}{next(self._names)}"

    def label(self, name: str) -> None:
        """Starts a block."""
        self.lines.append(f"{name}:")
        self.block = name

    def go(self, label: str) -> None:
        """Ends a block."""
        self.do(f"br label %{label}")

    def branch(self, condition: str, on_true: str, on_false: str) -> None:
        """Ends a block with a choice."""
        self.do(f"br i1 {condition}, label %{on_true}, label %{on_false}")

    def first_lane(self, bits: str) -> str:
        """Returns the number of the first lane whose bit is set; one must be."""
        wide = self.let(f"zext {self.bits} {bits} to i64")
        return self.call("llvm.cttz.i64", "i64", ("i64", wide), ("i1", "true"))

    def each_lane(self, bits: str, body: Callable[[str], None]) -> None:
        """Runs `body(lane)` for every bit that is set; at least one must be."""
        before, top, end = self.block, self.fresh("lane"), self.fresh("lanes.end")
        bottom = f"{top}.end"
        self.go(top)
        self.label(top)
        self.do(f"%{top}.bits = phi {self.bits} [{bits}, %{before}], [%{top}.rest, %{bottom}]")
        body(self.first_lane(f"%{top}.bits"))
        self.go(bottom)
        self.label(bottom)
        less = self.let(f"sub {self.bits} %{top}.bits, 1")
        self.do(f"%{top}.rest = and {self.bits} %{top}.bits, {less}")
        self.branch(self.any(f"%{top}.rest"), top, end)
        self.label(end)

    def repeat(self, count: int, body: Callable[[str], None]) -> None:
        """Runs `body(number)` for every number below the count, which is at least 1."""

        def step(number: str, values: Sequence[str]) -> Sequence[str]:
            body(number)
            return values

        self.accumulate(count, "", (), step)

    def over(self, shape: Sequence[int], body: Callable[[Index], None], index: Index = ()) -> None:
        """Runs `body` for every index of an array, `index` and one of `shape` behind it."""
        if not shape:
            body(index)
        elif shape[0] == 1:
            self.over(shape[1:], body, (*index, "0"))
        else:
            self.repeat(shape[0], lambda n: self.over(shape[1:], body, (*index, n)))

    def accumulate(
        self,
        count: int,
        kind: str,
        start: Sequence[str],
        body: Callable[[str, Sequence[str]], Sequence[str]],
    ) -> list[str]:
        """Returns what values of one type become by `body(number, values)` for every number."""
        before, top, end = self.block, self.fresh("each"), self.fresh("all")
        bottom, number = f"{top}.end", f"%{top}.n"
        names = [f"%{top}.v{place}" for place in range(len(start))]
        self.go(top)
        self.label(top)
        first = len(self.lines)
        following = body(number, names)
        self.go(bottom)
        self.label(bottom)
        more = self.let(f"add i64 {number}, 1")
        carried = [("i64", number, "0", more)]
        carried += [(kind, *each) for each in zip(names, start, following, strict=True)]
        self.lines[first:first] = [
            f"  {name} = phi {kind} [{value}, %{before}], [{then}, %{bottom}]"
            for kind, name, value, then in carried
        ]
        self.branch(self.let(f"icmp ult i64 {more}, {count}"), top, end)
        self.label(end)
        return list(following)

    def spread(self, value: str, dtype: str) -> str:
        """Returns a scalar in all lanes."""
        vector = self.vector(dtype)
        first = self.let(f"insertelement {vector} poison, {scalar_type(dtype)} {value}, i64 0")
        mask = f"<{self.width} x i32> zeroinitializer"
        return self.let(f"shufflevector {vector} {first}, {vector} poison, {mask}")
