"""Blocks of steps: values computed for all lanes, and inner loops."""

import dataclasses
from collections.abc import Sequence

from mjxwalk.engines.lanes.backend import operations
from mjxwalk.engines.lanes.backend.arrays import Arrays
from mjxwalk.engines.lanes.backend.gathers import Gathers, Neighbours, neighbours
from mjxwalk.engines.lanes.backend.values import Values
from mjxwalk.engines.lanes.backend.writer import Writer
from mjxwalk.engines.lanes.ir.arrays import IN_MEMORY
from mjxwalk.engines.lanes.ir.graph import Graph
from mjxwalk.engines.lanes.ir.program import RotatedLoop, Step


@dataclasses.dataclass(frozen=True)
class Blocks:
    """Writes what computes a program's steps."""

    graph: Graph
    writer: Writer
    values: Values
    gathers: Gathers
    arrays: Arrays

    def run(self, steps: Sequence[Step], live: str) -> None:
        """Computes steps; inner loops run for the lanes whose bit is set in `live`."""
        has_loops = any(isinstance(step, RotatedLoop) for step in steps)
        self._steps(steps, self.writer.mask_of(live) if has_loops else "")

    def _steps(self, steps: Sequence[Step], mask: str) -> None:
        """Computes steps; inner loops run for the lanes of the mask."""
        pairs = neighbours(self.graph, (step for step in steps if isinstance(step, int)))
        for step in steps:
            if isinstance(step, RotatedLoop):
                self._loop(step, mask)
            else:
                self._compute(step, pairs)

    def _compute(self, node_id: int, pairs: Neighbours) -> None:
        """Adds a node's instructions."""
        node = self.graph.nodes[node_id]
        if node.op == "input":
            return  # fetched where it is used
        if node_id in self.values:
            return  # its neighbour in a table brought it along
        if node.op == "inside":
            self.values[node_id] = self.values[node.args[0]]
            return
        if node.op == "element" or node.op in IN_MEMORY:
            self.arrays.compute(node_id)
            return
        if node.op in ("load", "lookup"):
            self.gathers.load(node_id, pairs)
            return
        args = [self.values[arg] for arg in node.args]
        self.values[node_id] = operations.emit(self.writer, self.graph, node, args)

    def _loop(self, loop: RotatedLoop, live: str) -> None:
        """An inner loop: runs while any lane wants a step, and holds the lanes that do not."""
        w, values, boolean = self.writer, self.values, self.writer.vector("bool")
        for node in sorted(loop.external_inputs):
            _ = values[node]  # before the loop, so that it is there after it
        start = w.let(f"and {boolean} {live}, {values[loop.first_test]}")
        initial = {place: values[node] for place, node in loop.initial.items()}
        kinds = {p: w.vector(self.graph.dtype(loop.carries[p])) for p in initial}
        before, top = w.block, w.fresh("turn")
        end, after = f"{top}.end", f"{top}.after"
        w.branch(w.any(w.bits_of(start)), top, after)
        w.label(top)
        w.do(f"%{top}.mask = phi {boolean} [{start}, %{before}], [%{top}.more, %{end}]")
        with values.scope():
            for place, value in initial.items():
                carry = f"%{top}.c{place}"
                w.do(f"{carry} = phi {kinds[place]} [{value}, %{before}], [{carry}.next, %{end}]")
                values[loop.carries[place]] = carry
            self._steps(loop.body, f"%{top}.mask")
            following = {place: values[node] for place, node in loop.following.items()}
            again = values[loop.next_test]
        w.go(end)
        w.label(end)
        for place, value in following.items():
            kind, carry = kinds[place], f"%{top}.c{place}"
            w.do(f"{carry}.next = select {boolean} %{top}.mask, {kind} {value}, {kind} {carry}")
        w.do(f"%{top}.more = and {boolean} %{top}.mask, {again}")
        w.branch(w.any(w.bits_of(f"%{top}.more")), top, after)
        w.label(after)
        for place, value in initial.items():
            carry = f"%{top}.c{place}"
            result = w.let(f"phi {kinds[place]} [{value}, %{before}], [{carry}.next, %{end}]")
            dtype = self.graph.dtype(loop.carries[place])
            found = self.graph.find("result", dtype, (), (loop.id, place))
            if found is not None:
                values[found] = result
