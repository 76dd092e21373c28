"""Loops over arrays in a thread's own memory: those of a single walker."""

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from mjxwalk.engines.lanes.backend import operations
from mjxwalk.engines.lanes.backend.scalar_writer import ScalarWriter
from mjxwalk.engines.lanes.backend.types import memory_type
from mjxwalk.engines.lanes.backend.writer import Index
from mjxwalk.engines.lanes.ir.arrays import IN_MEMORY, Elementwise, Product, View, num_elements
from mjxwalk.engines.lanes.ir.graph import Graph, Node

COLUMNS = 8  # of a product that are summed at a time, so that the left side is read once for all


@dataclasses.dataclass(frozen=True)
class ThreadArrays:
    """Writes the loops of a program.

    Attributes:
      value: returns the name or the constant of a scalar node.
      place: returns a place in an argument's memory, of the thread's walker.
    """

    graph: Graph
    writer: ScalarWriter
    value: Callable[[int], str]
    place: Callable[[int, str], str]

    def reservations(self) -> list[str]:
        """Returns the instructions that reserve memory for all arrays; they come first of all."""
        return [
            f"  {_area(number)} = alloca [{num_elements(node)} x {memory_type(node.dtype)}]"
            for number, node in enumerate(self.graph.nodes)
            if node.op in IN_MEMORY
        ]

    def element(self, node: Node) -> str:
        """Reads a number of an array."""
        return self.writer.load("ptr", _area(node.args[0]), str(node.data), node.dtype)

    def compute(self, node_id: int) -> None:
        """Computes an array."""
        node, area = self.graph.nodes[node_id], _area(node_id)
        if node.op == "array":
            for number, arg in enumerate(node.args):
                self.writer.store("ptr", area, str(number), node.dtype, self.value(arg))
        elif node.op == "product":
            self._product(node, node.data, area)
        else:
            self._elementwise(node, node.data, area)

    def _product(self, node: Node, product: Product, area: str) -> None:
        w, (rows, columns, terms) = self.writer, product.shape
        kind, flags = w.vector(node.dtype), operations.FLAGS

        def sums(first: str, block: int) -> None:
            """Computes and stores some columns of all rows."""
            places = [w.let(f"add i64 {first}, {column}") for column in range(block)]

            def more(term: str, before: Sequence[str]) -> list[str]:
                read = self._read
                left = [read(node, product.left, node.dtype, (str(r), term)) for r in range(rows)]
                right = [read(node, product.right, node.dtype, (each, term)) for each in places]
                times = [w.let(f"fmul {flags} {kind} {x}, {y}") for y in right for x in left]
                pairs = zip(before, times, strict=True)
                return [w.let(f"fadd {flags} {kind} {old}, {new}") for old, new in pairs]

            zeros = [w.splat(0, node.dtype)] * (rows * block)
            made = iter(w.accumulate(terms, kind, zeros, more))
            for each in places:
                for row in range(rows):
                    number = w.let(f"add i64 {each}, {row * columns}")
                    w.store("ptr", area, number, node.dtype, next(made))

        block = min(columns, COLUMNS)
        w.repeat(columns // block, lambda n: sums(w.let(f"mul i64 {n}, {block}"), block))
        if columns % block:
            sums(str(columns - columns % block), columns % block)

    def _elementwise(self, node: Node, each: Elementwise, area: str) -> None:
        """Applies an operation to all numbers, one after the other."""
        steps = [int(np.prod(each.shape[axis + 1 :])) for axis in range(len(each.shape))]

        def one(index: Index) -> None:
            pairs = zip(each.operands, each.dtypes, strict=True)
            operands = [self._read(node, view, dtype, index) for view, dtype in pairs]
            made = operations.written_out(self.writer, each, node.dtype, operands)
            self.writer.store("ptr", area, self._weighted(index, steps), node.dtype, made)

        self.writer.over(each.shape, one)

    def _read(self, node: Node, view: View, dtype: str, index: Index) -> str:
        """Returns the number of a view at an index."""
        if view.kind == "value":
            return self.value(node.args[int(view.source)])
        place = self._weighted(index, view.strides, view.first)
        pointer = self.writer.pointer
        if view.kind == "table":
            return self.writer.load(pointer, f"@{view.source}", place, dtype)
        if view.kind == "input":
            argument = int(view.source)
            place = self.place(argument, place)
            return self.writer.load(pointer, f"%input.{argument}", place, dtype)
        return self.writer.load("ptr", _area(node.args[int(view.source)]), place, dtype)

    def _weighted(self, index: Index, steps: Sequence[int], first: int = 0) -> str:
        """Returns `first` and the sum of indices times steps."""
        w, total = self.writer, str(first)
        for each, step in zip(index, steps, strict=True):
            if step:
                total = w.let(f"add i64 {total}, {w.let(f'mul i64 {each}, {step}')}")
        return total


def _area(node_id: int) -> str:
    """Returns the name of a pointer to an array."""
    return f"%array.{node_id}"
