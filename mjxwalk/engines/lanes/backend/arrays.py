"""Loops over arrays in the workspace: what is in memory, a vector of lanes for each number."""

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from mjxwalk.engines.lanes.backend import operations
from mjxwalk.engines.lanes.backend.types import memory_type
from mjxwalk.engines.lanes.backend.values import Values
from mjxwalk.engines.lanes.backend.workspace import (
    Layout,
    Workspace,
    from_memory,
    to_memory,
    vector_bytes,
)
from mjxwalk.engines.lanes.backend.writer import FLAGS, Index, Writer
from mjxwalk.engines.lanes.ir.arrays import Elementwise, Product, View
from mjxwalk.engines.lanes.ir.graph import Graph, Node


@dataclasses.dataclass(frozen=True)
class Arrays:
    """Writes the loops of a program."""

    graph: Graph
    writer: Writer
    workspace: Workspace
    values: Values
    layout: Layout

    def compute(self, node_id: int) -> None:
        """Computes an array, or reads an element of one."""
        node = self.graph.nodes[node_id]
        if node.op == "element":
            number = node.data * vector_bytes(node.dtype, self.writer.width)
            offset = self.layout.areas[node.args[0]] + number
            self.values[node_id] = self.workspace.read(offset, node.dtype)
            return
        area = self.layout.areas[node_id]
        if node.op == "array":
            for number, arg in enumerate(node.args):
                offset = area + number * vector_bytes(node.dtype, self.writer.width)
                self.workspace.write(offset, node.dtype, self.values[arg])
        elif node.op == "product":
            self._product(node, node.data, area)
        else:
            self._elementwise(node, node.data, area)

    def _product(self, node: Node, product: Product, area: int) -> None:
        """Sums a block of columns at a time, so that each number of the left side is read once."""
        rows, columns, _ = product.shape
        # Half of the registers are for sums, so that there is room for what is multiplied.
        block = max(1, min(columns, self.writer.target.registers // 2 // rows))

        def full(number: str) -> None:
            first = self.writer.let(f"mul i64 {number}, {block}")
            self._sums(node, product, area, first, block)

        self.writer.repeat(columns // block, full)
        if columns % block:
            self._sums(node, product, area, str(columns - columns % block), columns % block)

    def _sums(self, node: Node, product: Product, area: int, first: str, block: int) -> None:
        """Computes and stores some columns of all rows."""
        w, dtype, (rows, columns, terms) = self.writer, node.dtype, product.shape
        vector = w.vector(dtype)
        places = [w.let(f"add i64 {first}, {column}") for column in range(block)]
        read_left = [self._reader(node, product.left, dtype, [str(row)]) for row in range(rows)]
        read_right = [self._reader(node, product.right, dtype, [place]) for place in places]

        def more(term: str, sums: Sequence[str]) -> list[str]:
            left = [read([term]) for read in read_left]
            found: list[str] = []
            for column, read in enumerate(read_right):
                right = read([term])
                for row in range(rows):
                    times = w.let(f"fmul {FLAGS} {vector} {left[row]}, {right}")
                    before = sums[column * rows + row]
                    found.append(w.let(f"fadd {FLAGS} {vector} {before}, {times}"))
            return found

        zeros = ["zeroinitializer"] * (rows * block)
        sums = iter(w.accumulate(terms, vector, zeros, more))
        for place in places:
            for row in range(rows):
                number = w.let(f"add i64 {place}, {row * columns}")
                self._store(area, number, dtype, next(sums))

    def _elementwise(self, node: Node, each: Elementwise, area: int) -> None:
        """Applies an operation to all numbers, one after the other."""
        reads = [
            self._reader(node, view, dtype, [])
            for view, dtype in zip(each.operands, each.dtypes, strict=True)
        ]
        steps = [int(np.prod(each.shape[axis + 1 :])) for axis in range(len(each.shape))]

        def one(index: Index) -> None:
            made = operations.written_out(
                self.writer, each, node.dtype, [read(index) for read in reads]
            )
            self._store(area, self._weighted(index, steps), node.dtype, made)

        self.writer.over(each.shape, one)

    def _reader(self, node: Node, view: View, dtype: str, start: Index) -> Callable[[Index], str]:
        """Returns what reads a view's number, given what is left of its index after `start`."""
        w = self.writer
        if view.kind == "value":
            value = self.values[node.args[int(view.source)]]
            return lambda index: value
        if view.kind == "table":
            base, kind, size = f"@{view.source}", memory_type(dtype), 1
        elif view.kind == "input":
            base = self.workspace.pointer(self.layout.slots[int(view.source), 0])
            kind, size = f"<{w.width} x {memory_type(dtype)}>", w.width
        else:
            base = self.workspace.pointer(self.layout.areas[node.args[int(view.source)]])
            kind, size = f"<{w.width} x {memory_type(dtype)}>", w.width
        scalar = memory_type(dtype)
        place = self._weighted(start, view.strides, view.first)
        place = w.let(f"mul i64 {place}, {size}")
        base = w.let(f"getelementptr {scalar}, ptr {base}, i64 {place}")

        def read(index: Index) -> str:
            place = self._weighted(index, view.strides[len(start) :])
            place = w.let(f"mul i64 {place}, {size}")
            pointer = w.let(f"getelementptr {scalar}, ptr {base}, i64 {place}")
            align = min(64, np.dtype(dtype).itemsize * size)
            value = w.let(f"load {kind}, ptr {pointer}, align {align}")
            if view.kind != "table":
                return from_memory(w, value, dtype)
            if dtype == "bool":
                value = w.let(f"trunc i8 {value} to i1")
            return w.spread(value, dtype)

        return read

    def _weighted(self, index: Index, steps: Sequence[int], first: int = 0) -> str:
        """Returns `first` and the sum of indices times steps."""
        w, total = self.writer, str(first)
        for each, step in zip(index, steps, strict=False):
            if step:
                part = each if step == 1 else w.let(f"mul i64 {each}, {step}")
                total = part if total == "0" else w.let(f"add i64 {total}, {part}")
        return total

    def _store(self, area: int, number: str, dtype: str, value: str) -> None:
        """Stores a number of an array."""
        w, kind = self.writer, memory_type(dtype)
        place = w.let(f"mul i64 {number}, {w.width}")
        pointer = w.let(f"getelementptr {kind}, ptr {self.workspace.pointer(area)}, i64 {place}")
        align = min(64, vector_bytes(dtype, w.width))
        w.do(
            f"store <{w.width} x {kind}> {to_memory(w, value, dtype)}, ptr {pointer}, align {align}"
        )
