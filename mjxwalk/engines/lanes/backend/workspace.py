"""A thread's workspace: a vector for every input, carry, kept value and output of its lanes."""

import dataclasses
from collections.abc import Iterable, Sequence

import numpy as np

from mjxwalk.engines.lanes.backend.types import memory_type
from mjxwalk.engines.lanes.backend.writer import Writer
from mjxwalk.engines.lanes.ir import arrays
from mjxwalk.engines.lanes.ir.graph import LoopId, carried
from mjxwalk.engines.lanes.ir.program import Program, RotatedLoop, Step, needs_of
from mjxwalk.engines.lanes.ir.signature import Argument, Result


@dataclasses.dataclass(frozen=True)
class Span:
    """Consecutive numbers of an array that are in consecutive vectors of the workspace."""

    array: int
    first: int
    count: int
    offset: int


class Layout:
    """Where the workspace keeps what, as offsets in bytes.

    Attributes:
      size: of the workspace, bytes.
      walkers: the number of each lane's walker.
      slots: of each input number that is used, by array and place.
      inputs, outputs: the same as spans.
      carries: each carry of the program's loop, by its place.
      kept: nodes that the prologue computes and that a later block reads.
      areas: of each array.
    """

    def __init__(
        self,
        program: Program,
        arguments: Sequence[Argument],
        results: Sequence[Result],
        width: int,
    ) -> None:
        self._program = program
        self._graph = program.graph
        self._width = width
        self.size = 0
        self.walkers = self._reserve("int64")
        self.slots: dict[tuple[int, int], int] = {}
        self.inputs = self._lay_inputs(arguments)
        self.carries = self._lay_carries()
        self.areas = self._lay_areas()
        self.kept = self._lay_kept()
        self.outputs = self._lay_outputs(results)

    def offset_of(self, node_id: int) -> int:
        """Returns where a node's value is that an earlier block left in the workspace."""
        node = self._graph.nodes[node_id]
        if node.op == "input":
            return self.slots[node.data]
        return self.kept[node_id] if node_id in self.kept else self.carries[carried(node)[1]]

    def _reserve(self, dtype: str) -> int:
        """Returns the offset of a new vector."""
        size = vector_bytes(dtype, self._width)
        offset = -(-self.size // size) * size
        self.size = offset + size
        return offset

    def _lay_inputs(self, arguments: Sequence[Argument]) -> list[Span]:
        """Gives every input number that is used a vector; neighbours become one span."""
        used = {node.data for node in self._graph.nodes if node.op == "input"}
        for node in self._graph.nodes:
            for view in arrays.views(node):
                if view.kind == "input":  # all of it, so that its numbers are next to each other
                    argument = int(view.source)
                    used |= {(argument, place) for place in range(arguments[argument].size)}
        spans: list[Span] = []
        for array, place in sorted(used):
            dtype = arguments[array].dtype
            offset = self.slots[array, place] = self._reserve(dtype)
            last = spans[-1] if spans else None
            size = vector_bytes(dtype, self._width)
            if (last and (last.array, last.first + last.count) == (array, place)
                    and last.offset + last.count * size == offset):  # fmt: skip
                spans[-1] = dataclasses.replace(last, count=last.count + 1)
            else:
                spans.append(Span(array, place, 1, offset))
        return spans

    def _lay_carries(self) -> dict[int, int]:
        loop = self._program.loop
        initial = loop.initial.items() if loop else ()
        return {place: self._reserve(self._graph.dtype(node)) for place, node in initial}

    def _lay_areas(self) -> dict[int, int]:
        areas: dict[int, int] = {}
        for node_id, node in enumerate(self._graph.nodes):
            if node.op in arrays.IN_MEMORY:
                offsets = [self._reserve(node.dtype) for _ in range(arrays.num_elements(node))]
                areas[node_id] = offsets[0]
        return areas

    def _lay_kept(self) -> dict[int, int]:
        program = self._program
        if program.loop is None:
            return {}
        nodes, loops = _computed(program.prologue)
        later = {*program.loop.external_inputs, *program.outputs}
        for step in program.epilogue:
            later |= set(needs_of(self._graph, step))

        def is_early(node_id: int) -> bool:
            node = self._graph.nodes[node_id]
            if node.op == "result":
                return carried(node)[0] in loops
            return node.op != "input" and node_id in nodes and node_id not in self.areas

        return {n: self._reserve(self._graph.dtype(n)) for n in sorted(later) if is_early(n)}

    def _lay_outputs(self, results: Sequence[Result]) -> list[Span]:
        spans: list[Span] = []
        for array, result in enumerate(results):
            offsets = [self._reserve(result.dtype) for _ in range(result.size)]
            if offsets:
                spans.append(Span(array, 0, result.size, offsets[0]))
        return spans


def _computed(steps: Iterable[Step]) -> tuple[set[int], set[LoopId]]:
    """Returns the nodes that some steps compute, and the loops that they run."""
    nodes: set[int] = set()
    loops: set[LoopId] = set()
    for step in steps:
        if isinstance(step, RotatedLoop):
            loops.add(step.id)
        else:
            nodes.add(step)
    return nodes, loops


@dataclasses.dataclass(frozen=True)
class Workspace:
    """Writes what reads and writes the workspace."""

    writer: Writer

    def pointer(self, offset: int) -> str:
        """Returns a pointer into the workspace."""
        return self.writer.let(f"getelementptr i8, ptr %workspace, i64 {offset}")

    def read(self, offset: int, dtype: str) -> str:
        """Loads a vector from the workspace."""
        pointer = self.pointer(offset)
        value = self.writer.let(f"load {self._kind(dtype)}, ptr {pointer}, {self._align(dtype)}")
        return from_memory(self.writer, value, dtype)

    def write(self, offset: int, dtype: str, value: str) -> None:
        """Stores a vector in the workspace."""
        stored, kind = to_memory(self.writer, value, dtype), self._kind(dtype)
        self.writer.do(f"store {kind} {stored}, ptr {self.pointer(offset)}, {self._align(dtype)}")

    def _kind(self, dtype: str) -> str:
        return f"<{self.writer.width} x {memory_type(dtype)}>"

    def _align(self, dtype: str) -> str:
        return f"align {min(64, vector_bytes(dtype, self.writer.width))}"


def vector_bytes(dtype: str, width: int) -> int:
    """Returns the size of a vector in memory."""
    return np.dtype(dtype).itemsize * width


def from_memory(writer: Writer, value: str, dtype: str) -> str:
    """Returns a vector as loaded, a boolean from its bytes."""
    if dtype != "bool":
        return value
    return writer.let(f"trunc <{writer.width} x i8> {value} to {writer.vector('bool')}")


def to_memory(writer: Writer, value: str, dtype: str) -> str:
    """Returns a vector as it is stored, a boolean as bytes."""
    if dtype != "bool":
        return value
    return writer.let(f"zext {writer.vector('bool')} {value} to <{writer.width} x i8>")
