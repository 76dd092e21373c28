"""Loads at places that each walker computes: from shared inputs, its own, or tables of constants.

Linear interpolation reads neighbours. Two float32 that lie side by side at a computed place are
loaded as one number of 64 bits and taken apart, which halves the loads.
"""

import dataclasses
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from mjxwalk.engines.lanes.backend.types import memory_type
from mjxwalk.engines.lanes.backend.values import Values
from mjxwalk.engines.lanes.backend.workspace import Workspace, from_memory
from mjxwalk.engines.lanes.backend.writer import Writer
from mjxwalk.engines.lanes.ir.graph import Graph
from mjxwalk.engines.lanes.ir.signature import Argument

# The load of the number before or after, and whether it is the one after.
Neighbours = Mapping[int, tuple[int, bool]]


def neighbours(graph: Graph, nodes: Iterable[int]) -> Neighbours:
    """Returns which loads of a block read side by side."""
    pairs: dict[int, tuple[int, bool]] = {}
    found: dict[tuple[int, int, int], int] = {}
    for node_id in nodes:
        node = graph.nodes[node_id]
        if node.op == "load" and node.dtype == "float32":
            found[node.data, *_base_and_distance(graph, node.args[0])] = node_id
    for (argument, base, distance), first in sorted(found.items()):
        second = found.get((argument, base, distance + 1))
        if second is not None and first not in pairs:
            pairs[first] = second, True
            pairs[second] = first, False
    return pairs


def _base_and_distance(graph: Graph, index: int) -> tuple[int, int]:
    """Returns an index as another one and a constant distance from it."""
    node = graph.nodes[index]
    if node.op == "add":
        distance = graph.value(node.args[1])
        if distance is not None:
            return node.args[0], int(distance)
    return index, 0


@dataclasses.dataclass(frozen=True)
class Gathers:
    """Writes loads at computed places.

    Attributes:
      walkers: where the workspace has the number of each lane's walker.
    """

    graph: Graph
    arguments: Sequence[Argument]
    writer: Writer
    workspace: Workspace
    values: Values
    walkers: int

    def load(self, node_id: int, pairs: Neighbours) -> None:
        """Computes a `load` or `lookup`, and its neighbour if it has one."""
        node = self.graph.nodes[node_id]
        index = self.values[node.args[0]]
        if node.op == "lookup":
            self.values[node_id] = self._load(f"@{node.data}", index, "int32", node.dtype)
            return
        array, places, kind = f"%inputs.{node.data}", self._places(node.data, index), "int32"
        if not self.arguments[node.data].shared:
            kind = "int64"
        if node_id not in pairs:
            self.values[node_id] = self._load(array, places, kind, node.dtype)
            return
        other, other_is_after = pairs[node_id]
        w = self.writer
        if not other_is_after:
            places = w.let(f"sub {w.vector(kind)} {places}, {w.splat(1, kind)}")
        first, second = self._load_pair(array, places, kind)
        self.values[node_id] = first if other_is_after else second
        self.values[other] = second if other_is_after else first

    def _places(self, argument: int, index: str) -> str:
        """Returns places in an input's memory: in the walker's own row, unless all share it."""
        if self.arguments[argument].shared:
            return index
        w, wide = self.writer, self.writer.vector("int64")
        size = w.splat(self.arguments[argument].size, "int64")
        walkers = self.workspace.read(self.walkers, "int64")
        start = w.let(f"mul {wide} {walkers}, {size}")
        narrow = w.vector("int32")
        return w.let(f"add {wide} {start}, {w.let(f'zext {narrow} {index} to {wide}')}")

    def _load(self, array: str, places: str, kind: str, dtype: str) -> str:
        """Loads array[places] in every lane."""
        w, memory = self.writer, memory_type(dtype)
        pointers = w.let(f"getelementptr {memory}, ptr {array}, {w.vector(kind)} {places}")
        value = self._gather(pointers, memory, np.dtype(dtype).itemsize)
        return from_memory(w, value, dtype)

    def _load_pair(self, array: str, places: str, kind: str) -> tuple[str, str]:
        """Loads array[places] and array[places + 1] of float32 in every lane."""
        w, lanes = self.writer, self.writer.width
        pointers = w.let(f"getelementptr float, ptr {array}, {w.vector(kind)} {places}")
        pairs = self._gather(pointers, "i64", 4)
        both = w.let(f"bitcast <{lanes} x i64> {pairs} to <{2 * lanes} x float>")
        halves: list[str] = []
        for start in (0, 1):
            chosen = ", ".join(f"i32 {2 * lane + start}" for lane in range(lanes))
            halves.append(
                w.let(
                    f"shufflevector <{2 * lanes} x float> {both}, <{2 * lanes} x float> poison, "
                    f"<{lanes} x i32> <{chosen}>"
                )
            )
        return halves[0], halves[1]  # all of x86-64 and ARM64 is little-endian

    def _gather(self, pointers: str, memory: str, alignment: int) -> str:
        w, lanes = self.writer, self.writer.width
        vector = f"<{lanes} x {memory}>"
        suffix = {"float": "f32", "double": "f64"}.get(memory, memory)
        return w.call(
            f"llvm.masked.gather.v{lanes}{suffix}.v{lanes}p0", vector,
            (f"<{lanes} x ptr>", pointers), ("i32", str(alignment)),
            (w.vector("bool"), "splat (i1 true)"), (vector, "poison"),
        )  # fmt: skip
