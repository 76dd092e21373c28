"""The whole kernel as LLVM IR: taking walkers, running them, storing what came of them.

`void lanes(inputs, outputs, workspace, count, next, stop, spent)` is run by every thread at once:
  inputs, outputs: tables of pointers to contiguous arrays, a walker's numbers one after another.
  workspace: the thread's own memory: a vector for each input number, carry, kept value and output.
  next: the number of the next walker that nobody has taken, advanced atomically.
  stop: a flag that ends the work early.
  spent: two counters of the thread, lane-iterations with a walker and all lane-iterations.

With a loop, lanes are refilled: the step runs for all lanes until a walker ends; then a cold block
stores that walker, takes the next into the lane, and the step goes on. The prologue is recomputed
for all lanes there, which changes nothing for those that run: it depends on their inputs only.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from mjxwalk.engines.lanes.backend.arrays import Arrays
from mjxwalk.engines.lanes.backend.blocks import Blocks
from mjxwalk.engines.lanes.backend.gathers import Gathers
from mjxwalk.engines.lanes.backend.target import Target
from mjxwalk.engines.lanes.backend.transfer import Transfer
from mjxwalk.engines.lanes.backend.types import literal, memory_type
from mjxwalk.engines.lanes.backend.values import Values
from mjxwalk.engines.lanes.backend.workspace import Layout, Workspace
from mjxwalk.engines.lanes.backend.writer import Writer
from mjxwalk.engines.lanes.ir.graph import Array
from mjxwalk.engines.lanes.ir.program import Program, RotatedLoop
from mjxwalk.engines.lanes.ir.signature import Argument, Result


@dataclasses.dataclass(frozen=True)
class Kernel:
    """Text of a kernel and the memory that a thread of it needs, in bytes."""

    text: str
    workspace: int


ENTRY = (
    "define void @lanes(ptr noalias %inputs, ptr noalias %outputs, ptr noalias align 64 "
    "%workspace, i64 %count, ptr noalias %next, ptr %stop, ptr noalias %spent)"
)

# A vector on the stack makes LLVM align all of it: spilled vectors then never straddle two lines.
ALIGNED_STACK = (
    "  %aligned = alloca <16 x float>, align 64",
    "  store volatile i32 0, ptr %aligned",
)


def emit_kernel(
    program: Program, arguments: Sequence[Argument], results: Sequence[Result], target: Target
) -> Kernel:
    """Returns the IR of a program for a target."""
    emitter = _Emitter(program, arguments, results, target)
    emitter.emit()
    tables = [_table(name, array) for name, array in program.graph.tables.items()]
    enter, leave, declared = _subnormals_as_zero(target.processor)
    writer = emitter.writer
    text = "\n".join(
        [*tables, ENTRY + " {", "entry:", *ALIGNED_STACK, *enter, *writer.lines,
         "leave:", *leave, "  ret void", "}", *sorted(writer.declared | declared)]
    )  # fmt: skip
    return Kernel(text, emitter.layout.size)


def _table(name: str, array: Array) -> str:
    kind = memory_type(array.dtype.name)
    array = array.astype(np.uint8) if array.dtype == np.bool_ else array
    numbers = ", ".join(f"{kind} {literal(n)}" for n in array)
    return f"@{name} = private unnamed_addr constant [{array.size} x {kind}] [{numbers}], align 64"


def _subnormals_as_zero(processor: str) -> tuple[list[str], list[str], set[str]]:
    """Returns what switches subnormal numbers off and on again: they cost a hundred cycles each.

    JAX switches them off on a CPU too.
    """
    if processor.startswith(("x86", "i386", "i686")):
        enter = [
            "  %mode = alloca i32",
            "  %fast = alloca i32",
            "  call void @llvm.x86.sse.stmxcsr(ptr %mode)",
            "  %before = load i32, ptr %mode",
            "  %without = or i32 %before, 32832",  # flush to zero, denormals are zero
            "  store i32 %without, ptr %fast",
            "  call void @llvm.x86.sse.ldmxcsr(ptr %fast)",
        ]
        leave = ["  call void @llvm.x86.sse.ldmxcsr(ptr %mode)"]
        names = ("llvm.x86.sse.stmxcsr", "llvm.x86.sse.ldmxcsr")
        return enter, leave, {f"declare void @{name}(ptr)" for name in names}
    if processor.startswith(("aarch64", "arm64")):
        enter = [
            "  %before = call i64 @llvm.aarch64.get.fpcr()",
            "  %without = or i64 %before, 16777216",  # flush to zero
            "  call void @llvm.aarch64.set.fpcr(i64 %without)",
        ]
        leave = ["  call void @llvm.aarch64.set.fpcr(i64 %before)"]
        return enter, leave, {
            "declare i64 @llvm.aarch64.get.fpcr()",
            "declare void @llvm.aarch64.set.fpcr(i64)",
        }  # fmt: skip
    return [], [], set()


class _Emitter:
    """The parts that write a kernel, and its flow from block to block."""

    def __init__(
        self,
        program: Program,
        arguments: Sequence[Argument],
        results: Sequence[Result],
        target: Target,
    ) -> None:
        graph = program.graph
        self.program = program
        self.writer = Writer(target)
        self.layout = Layout(program, arguments, results, target.width)
        self.workspace = Workspace(self.writer)
        self.values = Values(graph, self.writer, self.workspace, self.layout)
        gathers = Gathers(
            graph, arguments, self.writer, self.workspace, self.values, self.layout.walkers
        )
        arrays = Arrays(graph, self.writer, self.workspace, self.values, self.layout)
        self.blocks = Blocks(graph, self.writer, self.values, gathers, arrays)
        self.transfer = Transfer(arguments, results, self.writer, self.workspace, self.layout)
        self._num_arrays = {"inputs": len(arguments), "outputs": len(results)}

    def emit(self) -> None:
        """Writes the kernel's blocks."""
        self._load_pointers()
        if self.program.loop is None:
            self._in_batches()
        else:
            self._refilling(self.program.loop)

    def _load_pointers(self) -> None:
        """Loads the pointers to all arrays."""
        w = self.writer
        for kind, count in self._num_arrays.items():
            for number in range(count):
                entry = w.let(f"getelementptr ptr, ptr %{kind}, i64 {number}")
                w.do(f"%{kind}.{number} = load ptr, ptr {entry}")

    def _in_batches(self) -> None:
        """A function without a loop: a vector of walkers after another."""
        w = self.writer
        w.go("batch")
        w.label("batch")
        first = w.let(f"atomicrmw add ptr %next, i64 {w.width} monotonic")
        w.branch(w.either(self._stopped(), w.let(f"icmp uge i64 {first}, %count")), "leave", "take")
        w.label("take")
        left = w.let(f"sub i64 %count, {first}")
        full = w.let(f"icmp uge i64 {left}, {w.width}")
        lanes = w.let(f"select i1 {full}, i64 {w.width}, i64 {left}")
        ones = w.let(f"shl nsw i64 -1, {lanes}")
        taken = w.let(f"trunc i64 {w.let(f'xor i64 {ones}, -1')} to {w.bits}")

        def take(lane: str) -> None:
            self.transfer.take_inputs(lane, w.let(f"add i64 {first}, {lane}"))

        w.each_lane(taken, take)
        self._count(w.let("add i64 0, 1"), taken)
        self._epilogue(taken)
        w.go("batch")

    def _refilling(self, loop: RotatedLoop) -> None:
        """A function with a loop: see the top of this file."""
        w = self.writer
        w.go("refill")
        w.label("refill")  # every end of a walker leads here, and so does the beginning
        ended = w.let(f"phi {w.bits} [0, %entry], [%ended.first, %prologue.end], [%ended, %spend]")
        live = w.let(f"phi {w.bits} [0, %entry], [%active, %prologue.end], [%live, %spend]")
        w.branch(self._stopped(), "leave", "refill.go")
        w.label("refill.go")
        w.branch(w.any(ended), "epilogue", "take")
        w.label("epilogue")
        self._epilogue(ended)
        w.go("take")
        w.label("take")
        kept = w.without(live, ended)
        new = self.transfer.take_walkers(w.inverted(kept))
        w.do(f"%active = or {w.bits} {kept}, {new}")
        w.branch(w.any(new), "prologue", "idle")
        w.label("idle")
        w.branch(w.any(kept), "steps", "leave")
        self._prologue(loop, new)
        self._steps(loop)

    def _prologue(self, loop: RotatedLoop, new: str) -> None:
        """Computes what steps and epilogue need of all lanes; starts the loop in new ones."""
        w, workspace, values = self.writer, self.workspace, self.values
        dtype_of = self.program.graph.dtype
        w.label("prologue")
        values.clear()
        self.blocks.run(self.program.prologue, "%active")
        for node, offset in self.layout.kept.items():
            workspace.write(offset, dtype_of(node), values[node])
        starting = w.mask_of(new)
        for place, node in loop.initial.items():
            dtype, offset = dtype_of(node), self.layout.carries[place]
            before = workspace.read(offset, dtype)
            workspace.write(offset, dtype, w.select(starting, values[node], before, dtype))
        stays = w.inverted(w.bits_of(values[loop.first_test]))
        w.go("prologue.end")
        w.label("prologue.end")
        w.do(f"%ended.first = and {w.bits} {new}, {stays}")
        w.branch(w.any("%ended.first"), "refill", "steps")

    def _steps(self, loop: RotatedLoop) -> None:
        """The hot loop: a step of all lanes, until a lane's walker ends."""
        w, values = self.writer, self.values
        w.label("steps")
        w.do(f"%live = phi {w.bits} [%active, %prologue.end], [%active, %idle]")
        w.go("step")
        w.label("step")
        w.do("%done = phi i64 [0, %steps], [%done.more, %step.end]")
        values.clear()
        self.blocks.run(loop.body, "%live")
        following = [(place, node, values[node]) for place, node in loop.following.items()]
        again = values[loop.next_test]
        for place, node, value in following:
            dtype = self.program.graph.dtype(node)
            self.workspace.write(self.layout.carries[place], dtype, value)
        goes_on = w.bits_of(again)
        w.go("step.end")
        w.label("step.end")
        w.do(f"%ended = and {w.bits} %live, {w.inverted(goes_on)}")
        w.do("%done.more = add i64 %done, 1")
        w.branch(w.either(w.any("%ended"), self._stopped()), "spend", "step")
        w.label("spend")
        self._count("%done.more", "%live")
        w.go("refill")

    def _epilogue(self, ended: str) -> None:
        """Computes the outputs of walkers that have ended, and stores them."""
        self.values.clear()
        self.blocks.run(self.program.epilogue, ended)
        self.transfer.store_outputs(self.program.outputs, self.values)
        self.writer.each_lane(ended, self.transfer.give_outputs)

    def _stopped(self) -> str:
        """Returns whether somebody outside wants an end."""
        flag = self.writer.let("load volatile i32, ptr %stop")
        return self.writer.let(f"icmp ne i32 {flag}, 0")

    def _count(self, steps: str, live: str) -> None:
        """Counts lane-iterations: those with a walker, and all."""
        w = self.writer
        wide = w.let(f"zext {w.bits} {live} to i64")
        busy = w.call("llvm.ctpop.i64", "i64", ("i64", wide))
        for place, lanes in enumerate((busy, str(w.width))):
            counter = w.let(f"getelementptr i64, ptr %spent, i64 {place}")
            more = w.let(f"mul i64 {steps}, {lanes}")
            total = w.let(f"add i64 {w.let(f'load i64, ptr {counter}')}, {more}")
            w.do(f"store i64 {total}, ptr {counter}")
