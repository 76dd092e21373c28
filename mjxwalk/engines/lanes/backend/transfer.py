"""Walkers in and out: from their arrays into a lane of the workspace, and back."""

import dataclasses
from collections.abc import Sequence

from mjxwalk.engines.lanes.backend.types import memory_type
from mjxwalk.engines.lanes.backend.values import Values
from mjxwalk.engines.lanes.backend.workspace import Layout, Span, Workspace, vector_bytes
from mjxwalk.engines.lanes.backend.writer import Writer
from mjxwalk.engines.lanes.ir.signature import Argument, Result

SHORT = 4  # numbers that are copied one by one rather than in a loop


@dataclasses.dataclass(frozen=True)
class Transfer:
    """Writes what takes walkers into lanes and gives back what came of them."""

    arguments: Sequence[Argument]
    results: Sequence[Result]
    writer: Writer
    workspace: Workspace
    layout: Layout

    def take_walkers(self, free: str) -> str:
        """Gives free lanes the next walkers, as far as there are any; returns which got one."""
        w = self.writer
        before, top, got, end = w.block, "take.lane", "take.got", "take.end"
        w.branch(w.any(free), top, end)
        w.label(top)
        w.do(f"%take.bits = phi {w.bits} [{free}, %{before}], [%take.rest, %take.next]")
        w.do(f"%take.new = phi {w.bits} [0, %{before}], [%take.more, %take.next]")
        walker = w.let("atomicrmw add ptr %next, i64 1 monotonic")
        w.branch(w.let(f"icmp ult i64 {walker}, %count"), got, end)
        w.label(got)
        self.take_inputs(w.first_lane("%take.bits"), walker)
        w.go("take.next")
        w.label("take.next")
        less = w.let(f"sub {w.bits} %take.bits, 1")
        w.do(f"%take.rest = and {w.bits} %take.bits, {less}")
        taken = w.let(f"xor {w.bits} %take.bits, %take.rest")
        w.do(f"%take.more = or {w.bits} %take.new, {taken}")
        w.branch(w.any("%take.rest"), top, end)
        w.label(end)
        return w.let(f"phi {w.bits} [0, %{before}], [%take.new, %{top}], [%take.more, %take.next]")

    def take_inputs(self, lane: str, walker: str) -> None:
        """Copies a walker's inputs into a lane of the workspace."""
        w = self.writer
        w.do(f"store i64 {walker}, ptr {self._walker_of(lane)}")
        for span in self.layout.inputs:
            argument = self.arguments[span.array]
            row = "0" if argument.shared else w.let(f"mul i64 {walker}, {argument.size}")
            array = f"%inputs.{span.array}"
            self._copy(span, argument.dtype, lane, row, array, into_lane=True)

    def store_outputs(self, outputs: Sequence[int], values: Values) -> None:
        """Puts every output into its vector of the workspace."""
        nodes = iter(outputs)
        for span in self.layout.outputs:
            dtype = self.results[span.array].dtype
            for number in range(span.count):
                offset = span.offset + number * vector_bytes(dtype, self.writer.width)
                self.workspace.write(offset, dtype, values[next(nodes)])

    def give_outputs(self, lane: str) -> None:
        """Copies a lane's outputs to where its walker's belong."""
        w = self.writer
        walker = w.let(f"load i64, ptr {self._walker_of(lane)}")
        for span in self.layout.outputs:
            result = self.results[span.array]
            row = w.let(f"mul i64 {walker}, {result.size}")
            array = f"%outputs.{span.array}"
            self._copy(span, result.dtype, lane, row, array, into_lane=False)

    def _walker_of(self, lane: str) -> str:
        """Returns a pointer to the number of a lane's walker."""
        walkers = self.workspace.pointer(self.layout.walkers)
        return self.writer.let(f"getelementptr i64, ptr {walkers}, i64 {lane}")

    def _copy(
        self, span: Span, dtype: str, lane: str, row: str, array: str, *, into_lane: bool
    ) -> None:
        """Copies a span between an array and a lane of the workspace, number after number."""
        w, kind = self.writer, memory_type(dtype)
        start = w.let(f"add i64 {row}, {span.first}")

        def copy(number: str) -> None:
            outside = w.let(f"add i64 {start}, {number}")
            outside = w.let(f"getelementptr {kind}, ptr {array}, i64 {outside}")
            inside = w.let(f"add i64 {w.let(f'mul i64 {number}, {w.width}')}, {lane}")
            pointer = self.workspace.pointer(span.offset)
            inside = w.let(f"getelementptr {kind}, ptr {pointer}, i64 {inside}")
            source, target = (outside, inside) if into_lane else (inside, outside)
            w.do(f"store {kind} {w.let(f'load {kind}, ptr {source}')}, ptr {target}")

        if span.count <= SHORT:
            for number in range(span.count):
                copy(str(number))
        else:
            w.repeat(span.count, copy)
