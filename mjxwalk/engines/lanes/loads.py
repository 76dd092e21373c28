"""Loads at places that each walker computes: from shared inputs, its own, or tables of constants.

Linear interpolation reads neighbours. Two float32 that lie side by side at a computed place are
loaded as one number of 64 bits and taken apart, which halves the loads.
"""

from collections.abc import Iterable

import numpy as np

from mjxwalk.engines.lanes.code import memory_type
from mjxwalk.engines.lanes.frame import Frame


class Loads(Frame):
    """A frame that can load numbers at computed places.

    Attributes:
      neighbours: the load of the number before or after, and whether it is the one after.
    """

    neighbours: dict[int, tuple[int, bool]]

    def pair(self, nodes: Iterable[int]) -> None:
        """Finds the loads of a block that read side by side."""
        self.neighbours = {}
        found: dict[tuple[int, int, int], int] = {}
        for node_id in nodes:
            node = self.graph.nodes[node_id]
            if node.op == "load" and node.dtype == "float32":
                base, offset = self._place(node.args[0])
                found[node.data, base, offset] = node_id
        for (argument, base, offset), first in sorted(found.items()):
            second = found.get((argument, base, offset + 1))
            if second is not None and first not in self.neighbours:
                self.neighbours[first] = second, True
                self.neighbours[second] = first, False

    def _place(self, index: int) -> tuple[int, int]:
        """Returns an index as another one and a constant distance from it."""
        node = self.graph.nodes[index]
        if node.op == "add":
            offset = self.graph.value(node.args[1])
            if offset is not None:
                return node.args[0], int(offset)
        return index, 0

    def load(self, node_id: int) -> None:
        """Computes a `load` or `lookup`, and its neighbour if it has one."""
        node = self.graph.nodes[node_id]
        index = self.value(node.args[0])
        if node.op == "lookup":
            self.values[node_id] = self._gathered(f"@{node.data}", index, node.dtype)
            return
        array = f"%inputs.{node.data}"
        spots, kind = self._spots(node.data, index), self.vector("int32")
        if not self.arguments[node.data].shared:
            kind = self.vector("int64")
        other, is_second = self.neighbours.get(node_id, (node_id, False))
        if other == node_id:
            self.values[node_id] = self._gathered(array, spots, node.dtype, kind)
            return
        if not is_second:  # this is the later of the two
            one = self.splat(1, "int32" if kind == self.vector("int32") else "int64")
            spots = self.let(f"sub {kind} {spots}, {one}")
        first, second = self._gathered_pair(array, spots, kind)
        self.values[node_id] = first if is_second else second
        self.values[other] = second if is_second else first

    def _spots(self, argument: int, index: str) -> str:
        """Returns places in an input's memory: in the walker's own row, unless all share it."""
        if self.arguments[argument].shared:
            return index
        narrow, wide = self.vector("int32"), self.vector("int64")
        size = self.splat(self.arguments[argument].size, "int64")
        start = self.let(f"mul {wide} {self.read(self.walkers, 'int64')}, {size}")
        return self.let(f"add {wide} {start}, {self.let(f'zext {narrow} {index} to {wide}')}")

    def _gathered(self, array: str, spots: str, dtype: str, kind: str = "") -> str:
        """Loads array[spots] in every lane."""
        kind = kind or self.vector("int32")
        memory = memory_type(dtype)
        pointers = self.let(f"getelementptr {memory}, ptr {array}, {kind} {spots}")
        value = self._gather(pointers, memory, np.dtype(dtype).itemsize)
        return self.from_memory(value, dtype)

    def _gathered_pair(self, array: str, spots: str, kind: str) -> tuple[str, str]:
        """Loads array[spots] and array[spots + 1] of float32 in every lane."""
        lanes = self.width
        pointers = self.let(f"getelementptr float, ptr {array}, {kind} {spots}")
        pairs = self._gather(pointers, "i64", 4)
        both = self.let(f"bitcast <{lanes} x i64> {pairs} to <{2 * lanes} x float>")
        halves: list[str] = []
        for start in (0, 1):
            places = ", ".join(f"i32 {2 * lane + start}" for lane in range(lanes))
            halves.append(
                self.let(
                    f"shufflevector <{2 * lanes} x float> {both}, <{2 * lanes} x float> poison, "
                    f"<{lanes} x i32> <{places}>"
                )
            )
        return halves[0], halves[1]  # all of x86-64 and ARM64 is little-endian

    def _gather(self, pointers: str, memory: str, alignment: int) -> str:
        lanes = self.width
        vector = f"<{lanes} x {memory}>"
        suffix = {"float": "f32", "double": "f64"}.get(memory, memory)
        return self.call(
            f"llvm.masked.gather.v{lanes}{suffix}.v{lanes}p0", vector,
            (f"<{lanes} x ptr>", pointers), ("i32", str(alignment)),
            (self.vector("bool"), "splat (i1 true)"), (vector, "poison"),
        )  # fmt: skip
