"""Blocks of steps: values computed for all lanes, and inner loops."""

from collections.abc import Iterable

from mjxwalk.engines.lanes.emit import emit
from mjxwalk.engines.lanes.loads import Loads
from mjxwalk.engines.lanes.program import Step, Turns


class Steps(Loads):
    """A frame that can compute a program's steps."""

    def run(self, steps: Iterable[Step], live: str) -> None:
        """Computes steps; inner loops run for the lanes whose bit is set in `live`."""
        steps = tuple(steps)
        mask = ""
        self.pair(step for step in steps if isinstance(step, int))
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
        if node_id in self.values:
            return  # its neighbour in a table brought it along
        if node.op in ("load", "lookup"):
            self.load(node_id)
        else:
            self.values[node_id] = emit(self, node_id)

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
        self.pair(step for step in loop.body if isinstance(step, int))
        for step in loop.body:
            if isinstance(step, Turns):
                self._turn(step, mask)
            else:
                self.compute(step)
