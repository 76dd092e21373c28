"""A thread's frame: its workspace, what moves in and out of it, and blocks of steps."""

import dataclasses
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from mjxwalk.engines.lanes.code import Code, Target, memory_type
from mjxwalk.engines.lanes.graph import carried
from mjxwalk.engines.lanes.program import Program, Step, Turns


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
        return self.from_memory(value, dtype)

    def write(self, offset: int, dtype: str, value: str) -> None:
        """Stores a vector in the workspace."""
        kind = f"<{self.width} x {memory_type(dtype)}>"
        if dtype == "bool":
            value = self.let(f"zext {self.vector('bool')} {value} to {kind}")
        self.do(f"store {kind} {value}, ptr {self.at(offset)}, align {self._alignment(dtype)}")

    def _alignment(self, dtype: str) -> int:
        return min(64, np.dtype(dtype).itemsize * self.width)

    def from_memory(self, value: str, dtype: str) -> str:
        """Returns a vector as loaded, a boolean from its bytes."""
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


def _computed(steps: Iterable[Step]) -> list[int]:
    """Returns the nodes of some steps; a loop counts as -1 - its number."""
    return [-1 - step.number if isinstance(step, Turns) else step for step in steps]
