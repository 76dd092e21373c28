"""Blocks of steps: values computed for all lanes, loads at computed places, inner loops."""

from collections.abc import Iterable

import numpy as np

from mjxwalk.engines.lanes.code import memory_type
from mjxwalk.engines.lanes.emit import emit
from mjxwalk.engines.lanes.frame import Frame
from mjxwalk.engines.lanes.program import Step, Turns


class Steps(Frame):
    """A frame that can compute a program's steps."""

    def run(self, steps: Iterable[Step], live: str) -> None:
        """Computes steps; inner loops run for the lanes whose bit is set in `live`."""
        mask = ""
        for step in steps:
            if isinstance(step, Turns):
                mask = mask or self.mask(live)
                self._turn(step, mask)
            else:
                self.compute(step)

    def compute(self, node_id: int) -> None:
        """Adds a node's instructions."""
        node = self.graph.nodes[node_id]
        if node.op == "input":
            return  # fetched where it is used
        if node.op == "load":
            array = self.arguments[node.data]
            index = self.value(node.args[0])
            self.values[node_id] = self._gather(
                f"%inputs.{node.data}", index, node.dtype, 0 if array.shared else array.size
            )
        elif node.op == "lookup":
            index = self.value(node.args[0])
            self.values[node_id] = self._gather(f"@{node.data}", index, node.dtype, 0)
        else:
            self.values[node_id] = emit(self, node_id)

    def _gather(self, array: str, index: str, dtype: str, row: int) -> str:
        """Loads array[index] in every lane, from the walker's own row if rows have a size."""
        kind, lanes = memory_type(dtype), self.width
        index_type = self.vector("int32")
        if row:
            walkers = self.read(self.walkers, "int64")
            wide = self.vector("int64")
            start = self.let(f"mul {wide} {walkers}, {self.splat(row, 'int64')}")
            index = self.let(
                f"add {wide} {start}, {self.let(f'zext {index_type} {index} to {wide}')}"
            )
            index_type = wide
        spots = self.let(f"getelementptr {kind}, ptr {array}, {index_type} {index}")
        name = f"llvm.masked.gather.v{lanes}{_suffix(kind)}.v{lanes}p0"
        value = self.call(
            name, f"<{lanes} x {kind}>", (f"<{lanes} x ptr>", spots),
            ("i32", str(np.dtype(dtype).itemsize)), (self.vector("bool"), "splat (i1 true)"),
            (f"<{lanes} x {kind}>", "poison"),
        )  # fmt: skip
        return self._from_memory(value, dtype)

    def _turn(self, loop: Turns, live: str) -> None:
        """An inner loop: runs while any lane wants a step, and holds the lanes that do not."""
        for node in sorted(loop.needs):
            self.value(node)  # before the loop, so that it is there after it
        boolean = self.vector("bool")
        start = self.let(f"and {boolean} {live}, {self.value(loop.first)}")
        initial = {place: self.value(node) for place, node in loop.initial.items()}
        before, top = self.block, self.fresh("turn")
        end, after = f"{top}.end", f"{top}.after"
        self.branch(self.any(start), top, after)
        self.label(top)
        self.do(f"%{top}.mask = phi {boolean} [{start}, %{before}], [%{top}.more, %{end}]")
        outer = dict(self.values)
        for place, value in initial.items():
            carry, kind = f"%{top}.c{place}", self.vector(self.dtype(loop.carries[place]))
            self.do(f"{carry} = phi {kind} [{value}, %{before}], [{carry}.next, %{end}]")
            self.values[loop.carries[place]] = carry
        self._body(loop, f"%{top}.mask")
        following = {place: self.value(node) for place, node in loop.following.items()}
        again = self.value(loop.again)
        self.go(end)
        self.label(end)
        for place, value in following.items():
            kind = self.vector(self.dtype(loop.carries[place]))
            carry = f"%{top}.c{place}"
            chosen = f"select {boolean} %{top}.mask, {kind} {value}, {kind} {carry}"
            self.do(f"{carry}.next = {chosen}")
        self.do(f"%{top}.more = and {boolean} %{top}.mask, {again}")
        self.branch(self.any(f"%{top}.more"), top, after)
        self.label(after)
        self.values = outer
        for place, value in initial.items():
            kind, carry = self.vector(self.dtype(loop.carries[place])), f"%{top}.c{place}"
            result = self.let(f"phi {kind} [{value}, %{before}], [{carry}.next, %{end}]")
            found = self.graph.find(
                "result", self.dtype(loop.carries[place]), (), (loop.number, place)
            )
            if found is not None:
                self.values[found] = result

    def _body(self, loop: Turns, mask: str) -> None:
        for step in loop.body:
            if isinstance(step, Turns):
                self._turn(step, mask)
            else:
                self.compute(step)


def _suffix(kind: str) -> str:
    return {"float": "f32", "double": "f64"}.get(kind, kind)
