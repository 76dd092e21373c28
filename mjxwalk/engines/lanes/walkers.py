"""Walkers in and out: from their arrays into a lane of the workspace, and back."""

from collections.abc import Callable

import numpy as np

from mjxwalk.engines.lanes.code import memory_type
from mjxwalk.engines.lanes.frame import Run
from mjxwalk.engines.lanes.steps import Steps

SHORT = 4  # numbers that are copied one by one rather than in a loop


class Walkers(Steps):
    """A frame that can take walkers and give back what came of them."""

    def take_walkers(self, free: str) -> str:
        """Gives free lanes the next walkers, as far as there are any; returns which got one."""
        before, top, got, end = self.block, "take.lane", "take.got", "take.end"
        self.branch(self.let(f"icmp ne {self.bits} {free}, 0"), top, end)
        self.label(top)
        self.do(f"%take.bits = phi {self.bits} [{free}, %{before}], [%take.rest, %take.next]")
        self.do(f"%take.new = phi {self.bits} [0, %{before}], [%take.more, %take.next]")
        walker = self.let("atomicrmw add ptr %next, i64 1 monotonic")
        self.branch(self.let(f"icmp ult i64 {walker}, %count"), got, end)
        self.label(got)
        wide = self.let(f"zext {self.bits} %take.bits to i64")
        lane = self.call("llvm.cttz.i64", "i64", ("i64", wide), ("i1", "true"))
        self.take_inputs(lane, walker)
        self.go("take.next")
        self.label("take.next")
        less = self.let(f"sub {self.bits} %take.bits, 1")
        self.do(f"%take.rest = and {self.bits} %take.bits, {less}")
        taken = self.let(f"xor {self.bits} %take.bits, %take.rest")
        self.do(f"%take.more = or {self.bits} %take.new, {taken}")
        self.branch(self.let(f"icmp ne {self.bits} %take.rest, 0"), top, end)
        self.label(end)
        return self.let(
            f"phi {self.bits} [0, %{before}], [%take.new, %{top}], [%take.more, %take.next]"
        )

    def take_inputs(self, lane: str, walker: str) -> None:
        """Copies a walker's inputs into a lane of the workspace."""
        spot = self.let(f"getelementptr i64, ptr {self.at(self.walkers)}, i64 {lane}")
        self.do(f"store i64 {walker}, ptr {spot}")
        for run in self.inputs:
            argument = self.arguments[run.array]
            row = "0" if argument.shared else self.let(f"mul i64 {walker}, {argument.size}")
            array = f"%inputs.{run.array}"
            self._copy(run, argument.dtype, lane, row, lambda s, lane_spot: (s, lane_spot), array)

    def store_outputs(self) -> None:
        """Puts every output into its vector of the workspace."""
        values = iter(self.program.outputs)
        for run in self.outputs:
            dtype = self.results[run.array].dtype
            step = np.dtype(dtype).itemsize * self.width
            for number in range(run.count):
                self.write(run.offset + number * step, dtype, self.value(next(values)))

    def give_outputs(self, lane: str) -> None:
        """Copies a lane's outputs to where its walker's belong."""
        spot = self.let(f"getelementptr i64, ptr {self.at(self.walkers)}, i64 {lane}")
        walker = self.let(f"load i64, ptr {spot}")
        for run in self.outputs:
            result = self.results[run.array]
            row = self.let(f"mul i64 {walker}, {result.size}")
            array = f"%outputs.{run.array}"
            self._copy(run, result.dtype, lane, row, lambda s, lane_spot: (lane_spot, s), array)

    def _copy(
        self,
        run: Run,
        dtype: str,
        lane: str,
        row: str,
        direction: Callable[[str, str], tuple[str, str]],
        array: str,
    ) -> None:
        """Copies a run between an array and a lane of the workspace, one number after another."""
        kind = memory_type(dtype)
        start = self.let(f"add i64 {row}, {run.first}")
        step = self.width

        def copy(number: str) -> None:
            outside = self.let(f"add i64 {start}, {number}")
            outside = self.let(f"getelementptr {kind}, ptr {array}, i64 {outside}")
            inside = self.let(f"add i64 {self.let(f'mul i64 {number}, {step}')}, {lane}")
            inside = self.let(f"getelementptr {kind}, ptr {self.at(run.offset)}, i64 {inside}")
            source, target = direction(outside, inside)
            self.do(f"store {kind} {self.let(f'load {kind}, ptr {source}')}, ptr {target}")

        if run.count <= SHORT:
            for number in range(run.count):
                copy(str(number))
        else:
            self._count_to(run.count, copy)

    def _count_to(self, count: int, body: Callable[[str], None]) -> None:
        before, top, end = self.block, self.fresh("copy"), self.fresh("copied")
        self.go(top)
        self.label(top)
        self.do(f"%{top}.n = phi i64 [0, %{before}], [%{top}.more, %{top}]")
        body(f"%{top}.n")
        self.do(f"%{top}.more = add i64 %{top}.n, 1")
        self.branch(self.let(f"icmp ult i64 %{top}.more, {count}"), top, end)
        self.label(end)
