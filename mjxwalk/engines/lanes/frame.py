"""A thread's frame: its workspace, what moves in and out of it, and blocks of steps."""

import dataclasses
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from mjxwalk.engines.lanes.emit import Code, Target, memory_type
from mjxwalk.engines.lanes.graph import carried
from mjxwalk.engines.lanes.program import Program, Step, Turns

SHORT = 4  # numbers that are copied one by one rather than in a loop


@dataclasses.dataclass(frozen=True)
class Argument:
    """An input of the kernel: numbers per walker, or in all if shared by the walkers."""

    size: int
    dtype: str
    shared: bool


@dataclasses.dataclass(frozen=True)
class Result:
    """An output of the kernel: numbers per walker."""

    size: int
    dtype: str


@dataclasses.dataclass(frozen=True)
class Run:
    """Consecutive numbers of an array that stand in consecutive vectors of the workspace."""

    array: int
    first: int
    count: int
    offset: int


class Frame(Code):
    """Code that knows where everything is kept.

    Attributes:
      carried: where each carry of the program's loop is kept, by its place.
      kept: where a node that is computed in one block and needed in another is kept.
    """

    def __init__(
        self,
        program: Program,
        arguments: Sequence[Argument],
        results: Sequence[Result],
        target: Target,
    ) -> None:
        super().__init__(program.graph, target)
        self.program = program
        self.arguments = arguments
        self.results = results
        self.bits = f"i{self.width}"
        self.workspace = 0
        self.walkers = self._reserve("int64")
        self.inputs = self._lay_inputs()
        self.carried = self._lay_carries()
        self.kept = self._lay_kept()
        self.outputs = self._lay_outputs()
        self._pointers()

    # Where things are kept

    def _reserve(self, dtype: str) -> int:
        """Returns the offset of a new vector in the workspace."""
        size = np.dtype(dtype).itemsize * self.width
        offset = -(-self.workspace // size) * size
        self.workspace = offset + size
        return offset

    def _lay_inputs(self) -> list[Run]:
        """Gives every input number that is used a vector; neighbours become one run."""
        self._input_slots: dict[tuple[int, int], int] = {}
        used = {node.data for node in self.graph.nodes if node.op == "input"}
        runs: list[Run] = []
        for array, place in sorted(used):
            dtype = self.arguments[array].dtype
            offset = self._input_slots[array, place] = self._reserve(dtype)
            last = runs[-1] if runs else None
            size = np.dtype(dtype).itemsize * self.width
            if (last and (last.array, last.first + last.count) == (array, place)
                    and last.offset + last.count * size == offset):  # fmt: skip
                runs[-1] = dataclasses.replace(last, count=last.count + 1)
            else:
                runs.append(Run(array, place, 1, offset))
        return runs

    def _lay_carries(self) -> dict[int, int]:
        loop = self.program.loop
        return {p: self._reserve(self.dtype(n)) for p, n in loop.initial.items()} if loop else {}

    def _lay_kept(self) -> dict[int, int]:
        """Finds the nodes of the prologue that a later block reads."""
        program = self.program
        if program.loop is None:
            return {}
        computed = set(_computed(program.prologue))
        later = {*program.loop.needs, *program.outputs, *self._needs(program.epilogue)}
        return {
            n: self._reserve(self.dtype(n)) for n in sorted(later) if self._comes_early(n, computed)
        }

    def _needs(self, steps: Iterable[Step]) -> set[int]:
        needs = (s.needs if isinstance(s, Turns) else self.graph.nodes[s].args for s in steps)
        return {node for some in needs for node in some}

    def _comes_early(self, node_id: int, computed: set[int]) -> bool:
        node = self.graph.nodes[node_id]
        if node.op == "result":
            loop = self.program.loop
            number = carried(node)[0]
            return loop is not None and number != loop.number and -1 - number in computed
        return node.op != "input" and node_id in computed

    def _lay_outputs(self) -> list[Run]:
        runs: list[Run] = []
        for array, result in enumerate(self.results):
            offsets = [self._reserve(result.dtype) for _ in range(result.size)]
            if offsets:
                runs.append(Run(array, 0, result.size, offsets[0]))
        return runs

    def _pointers(self) -> None:
        """Loads the pointers to all arrays."""
        for kind, count in (("inputs", len(self.arguments)), ("outputs", len(self.results))):
            for number in range(count):
                entry = self.let(f"getelementptr ptr, ptr %{kind}, i64 {number}")
                self.do(f"%{kind}.{number} = load ptr, ptr {entry}")

    def dtype(self, node: int) -> str:
        """Returns the type of a node."""
        return self.graph.nodes[node].dtype

    # Reading and writing

    def at(self, offset: int) -> str:
        """Returns a pointer into the workspace."""
        return self.let(f"getelementptr i8, ptr %workspace, i64 {offset}")

    def read(self, offset: int, dtype: str) -> str:
        """Loads a vector from the workspace."""
        kind = f"<{self.width} x {memory_type(dtype)}>"
        value = self.let(f"load {kind}, ptr {self.at(offset)}, align {self._alignment(dtype)}")
        return self._from_memory(value, dtype)

    def write(self, offset: int, dtype: str, value: str) -> None:
        """Stores a vector in the workspace."""
        kind = f"<{self.width} x {memory_type(dtype)}>"
        if dtype == "bool":
            value = self.let(f"zext {self.vector('bool')} {value} to {kind}")
        self.do(f"store {kind} {value}, ptr {self.at(offset)}, align {self._alignment(dtype)}")

    def _alignment(self, dtype: str) -> int:
        return min(64, np.dtype(dtype).itemsize * self.width)

    def _from_memory(self, value: str, dtype: str) -> str:
        if dtype != "bool":
            return value
        return self.let(f"trunc <{self.width} x i8> {value} to {self.vector('bool')}")

    def fetch(self, node_id: int) -> str:
        """Reads a value that another block left in the workspace."""
        node = self.graph.nodes[node_id]
        if node.op == "input":
            return self.read(self._input_slots[node.data], node.dtype)
        if node_id in self.kept:
            return self.read(self.kept[node_id], node.dtype)
        return self.read(self.carried[carried(node)[1]], node.dtype)

    def keep(self) -> None:
        """Stores what later blocks read."""
        for node, offset in self.kept.items():
            self.write(offset, self.dtype(node), self.value(node))

    # Flow

    def go(self, label: str) -> None:
        """Ends a block."""
        self.do(f"br label %{label}")

    def branch(self, condition: str, on_true: str, on_false: str) -> None:
        """Ends a block with a choice."""
        self.do(f"br i1 {condition}, label %{on_true}, label %{on_false}")

    def either(self, x: str, y: str) -> str:
        """Returns x or y, single bits."""
        return self.let(f"or i1 {x}, {y}")

    def stopped(self) -> str:
        """Returns whether somebody outside wants an end."""
        flag = self.let("load volatile i32, ptr %stop")
        return self.let(f"icmp ne i32 {flag}, 0")

    def mask(self, bits: str) -> str:
        """Returns bits as a vector of booleans."""
        return self.let(f"bitcast {self.bits} {bits} to {self.vector('bool')}")

    def any(self, mask: str) -> str:
        """Returns whether any lane of a mask is set."""
        bits = self.let(f"bitcast {self.vector('bool')} {mask} to {self.bits}")
        return self.let(f"icmp ne {self.bits} {bits}, 0")

    def spend(self, steps: str, live: str) -> None:
        """Counts lane-iterations: those with a walker, and all."""
        wide = self.let(f"zext {self.bits} {live} to i64")
        busy = self.call("llvm.ctpop.i64", "i64", ("i64", wide))
        for place, lanes in enumerate((busy, str(self.width))):
            spot = self.let(f"getelementptr i64, ptr %spent, i64 {place}")
            more = self.let(f"mul i64 {steps}, {lanes}")
            total = self.let(f"add i64 {self.let(f'load i64, ptr {spot}')}, {more}")
            self.do(f"store i64 {total}, ptr {spot}")

    def each_lane(self, bits: str, body: Callable[[str], None]) -> None:
        """Runs `body(lane)` for every bit that is set; at least one must be."""
        before, top, end = self.block, self.fresh("lane"), self.fresh("lanes.end")
        bottom = f"{top}.end"
        self.go(top)
        self.label(top)
        self.do(f"%{top}.bits = phi {self.bits} [{bits}, %{before}], [%{top}.rest, %{bottom}]")
        wide = self.let(f"zext {self.bits} %{top}.bits to i64")
        body(self.call("llvm.cttz.i64", "i64", ("i64", wide), ("i1", "true")))
        self.go(bottom)
        self.label(bottom)
        less = self.let(f"sub {self.bits} %{top}.bits, 1")
        self.do(f"%{top}.rest = and {self.bits} %{top}.bits, {less}")
        self.branch(self.let(f"icmp ne {self.bits} %{top}.rest, 0"), top, end)
        self.label(end)

    # Walkers in and out

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

    # Steps

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
            super().compute(node_id)

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


def _computed(steps: Iterable[Step]) -> list[int]:
    """Returns the nodes of some steps; a loop counts as -1 - its number."""
    return [-1 - step.number if isinstance(step, Turns) else step for step in steps]
