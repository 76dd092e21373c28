"""A kernel in which every thread runs one walker from its start to its end, as LLVM IR.

Numbers are plain scalars and loops are branches: a GPU masks the threads of a warp whose loop has
ended. What is computed before a loop is kept by the compiler, in registers or in the thread's own
memory, where the numbers of neighbouring threads lie side by side.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from mjxwalk.engines.lanes.backend import operations
from mjxwalk.engines.lanes.backend.scalar_writer import ScalarWriter
from mjxwalk.engines.lanes.backend.target import Target
from mjxwalk.engines.lanes.backend.thread_arrays import ThreadArrays
from mjxwalk.engines.lanes.backend.types import literal, memory_type
from mjxwalk.engines.lanes.ir.arrays import IN_MEMORY
from mjxwalk.engines.lanes.ir.graph import Graph, Node
from mjxwalk.engines.lanes.ir.program import Program, RotatedLoop, Step
from mjxwalk.engines.lanes.ir.signature import Argument, Result


class Frame(NamedTuple):
    """What is around the code of one walker.

    Attributes:
      pointer: LLVM's type of a pointer to an argument, an output or a table.
      space: what LLVM writes before `constant` where a table is defined.
      head: the function's first lines.
      start: lines after the reservations of memory, up to the block `walk`; together with the head
        they define `%input.N` and `%output.N`, a pointer to each array, and `%walker`, the number
        of the thread's walker.
      tail: lines after the code of a walker, which ends with a branch to the label `end`.
    """

    pointer: str
    space: str
    head: Sequence[str]
    start: Sequence[str]
    tail: Sequence[str]


def emit_thread_kernel(
    program: Program,
    arguments: Sequence[Argument],
    results: Sequence[Result],
    target: Target,
    frame: Frame,
) -> str:
    """Returns the IR of a program, for a target of width 1."""
    walker = _Walker(program, arguments, target, frame.pointer)
    walker.run(results)
    tables = [_table(program.graph, name, frame.space) for name in program.graph.tables]
    reserved = walker.arrays.reservations()
    lines = [*tables, *frame.head, *reserved, *frame.start, *walker.writer.lines, *frame.tail]
    return "\n".join([*lines, *sorted(walker.writer.declared)])


def _table(graph: Graph, name: str, space: str) -> str:
    array = graph.tables[name]
    kind = memory_type(array.dtype.name)
    as_stored = array.view(np.uint8) if kind == "i8" else array
    numbers = ", ".join(f"{kind} {literal(n)}" for n in as_stored)
    return f"@{name} = internal {space}constant [{array.size} x {kind}] [{numbers}], align 16"


class _Walker:
    """Writes what a single walker computes; every node has one name, where it is computed."""

    def __init__(
        self, program: Program, arguments: Sequence[Argument], target: Target, pointer: str
    ) -> None:
        self.program = program
        self.graph = program.graph
        self.arguments = arguments
        self.writer = ScalarWriter(target, pointer)
        self.writer.block = "walk"
        self.arrays = ThreadArrays(program.graph, self.writer, self._value, self._place)
        self.names: dict[int, str] = {}

    def run(self, results: Sequence[Result]) -> None:
        """Writes the program and the stores of its outputs."""
        program, w = self.program, self.writer
        self._load_inputs()
        self._steps(program.prologue)
        if program.loop is not None:
            self._loop(program.loop)
        self._steps(program.epilogue)
        outputs = iter(program.outputs)
        for number, result in enumerate(results):
            for place in range(result.size):
                at = self._in_row(result.size, str(place))
                value = self._value(next(outputs))
                w.store(w.pointer, f"%output.{number}", at, result.dtype, value)
        w.go("end")

    def _value(self, node_id: int) -> str:
        """Returns the name or the constant of a node that has been computed."""
        known = self.graph.value(node_id)
        if known is not None:
            return self.writer.splat(known, known.dtype.name)
        return self.names[node_id]

    def _load_inputs(self) -> None:
        """Loads every number of an argument that has a fixed place, before anything else."""
        for node_id, node in enumerate(self.graph.nodes):
            if node.op == "input":
                argument, offset = node.data
                place = self._place(argument, str(offset))
                self.names[node_id] = self._read(f"%input.{argument}", place, node.dtype)

    def _place(self, argument: int, index: str) -> str:
        """Returns a place in an argument's memory: in the walker's row, unless all share it."""
        if self.arguments[argument].shared:
            return index
        return self._in_row(self.arguments[argument].size, index)

    def _in_row(self, size: int, index: str) -> str:
        """Returns a place in an array that has so many numbers for each walker."""
        start = self.writer.let(f"mul i64 %walker, {size}")
        return self.writer.let(f"add i64 {start}, {index}")

    def _read(self, array: str, place: str, dtype: str) -> str:
        return self.writer.load(self.writer.pointer, array, place, dtype)

    def _steps(self, steps: Iterable[Step]) -> None:
        for step in steps:
            if isinstance(step, RotatedLoop):
                self._loop(step)
            elif self.graph.nodes[step].op in IN_MEMORY:
                self.arrays.compute(step)
            elif self.graph.nodes[step].op != "input":
                self.names[step] = self._compute(self.graph.nodes[step])

    def _compute(self, node: Node) -> str:
        """Adds a node's instructions; returns the name of its value."""
        if node.op == "element":
            return self.arrays.element(node)
        args = [self._value(arg) for arg in node.args]
        if node.op not in ("load", "lookup"):
            return operations.emit(self.writer, self.graph, node, args)
        index = self.writer.let(f"zext i32 {args[0]} to i64")
        if node.op == "lookup":
            return self._read(f"@{node.data}", index, node.dtype)
        return self._read(f"%input.{node.data}", self._place(node.data, index), node.dtype)

    def _loop(self, loop: RotatedLoop) -> None:
        """Adds a loop: a test before the first step and one after every step."""
        w, graph = self.writer, self.graph
        before, top = w.block, w.fresh("turn")
        after = f"{top}.after"
        initial = {place: self._value(node) for place, node in loop.initial.items()}
        kinds = {place: w.vector(graph.dtype(node)) for place, node in loop.initial.items()}
        w.branch(self._value(loop.first_test), top, after)
        w.label(top)
        start = len(w.lines)
        self.names |= {node: f"%{top}.c{place}" for place, node in loop.carries.items()}
        self._steps(loop.body)
        following = {place: self._value(node) for place, node in loop.following.items()}
        bottom = w.block
        w.lines[start:start] = [
            f"  %{top}.c{place} = phi {kinds[place]} "
            f"[{initial[place]}, %{before}], [{value}, %{bottom}]"
            for place, value in following.items()
        ]
        w.branch(self._value(loop.next_test), top, after)
        w.label(after)
        for place, value in following.items():
            node = graph.find("result", graph.dtype(loop.carries[place]), (), (loop.id, place))
            if node is not None:
                self.names[node] = w.let(
                    f"phi {kinds[place]} [{initial[place]}, %{before}], [{value}, %{bottom}]"
                )
