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

from mjxwalk.engines.lanes.code import Target, literal, memory_type
from mjxwalk.engines.lanes.frame import Argument, Result
from mjxwalk.engines.lanes.graph import Array
from mjxwalk.engines.lanes.program import Program, Turns
from mjxwalk.engines.lanes.walkers import Walkers


@dataclasses.dataclass(frozen=True)
class Kernel:
    """Machine-independent text of a kernel and the memory that a thread of it needs, in bytes."""

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


def kernel(
    program: Program, arguments: Sequence[Argument], results: Sequence[Result], target: Target
) -> Kernel:
    """Returns the IR of a program for a target."""
    frame = Walkers(program, arguments, results, target)
    write = _refilling if program.loop is not None else _in_batches
    write(frame)
    tables = [_table(name, array) for name, array in program.graph.tables.items()]
    enter, leave, declared = _subnormals_as_zero(target.processor)
    text = "\n".join(
        [*tables, ENTRY + " {", "entry:", *ALIGNED_STACK, *enter, *frame.lines,
         "leave:", *leave, "  ret void", "}", *sorted(frame.declared | declared)]
    )  # fmt: skip
    return Kernel(text, frame.workspace)


def _table(name: str, array: Array) -> str:
    kind = memory_type(array.dtype.name)
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


def _in_batches(f: Walkers) -> None:
    """A function without a loop: a vector of walkers after another."""
    f.go("batch")
    f.label("batch")
    first = f.let(f"atomicrmw add ptr %next, i64 {f.width} monotonic")
    f.branch(f.either(f.stopped(), f.let(f"icmp uge i64 {first}, %count")), "leave", "take")
    f.label("take")
    left = f.let(f"sub i64 %count, {first}")
    full = f.let(f"icmp uge i64 {left}, {f.width}")
    lanes = f.let(f"select i1 {full}, i64 {f.width}, i64 {left}")
    ones = f.let(f"shl nsw i64 -1, {lanes}")
    taken = f.let(f"trunc i64 {f.let(f'xor i64 {ones}, -1')} to {f.bits}")

    def take(lane: str) -> None:
        f.take_inputs(lane, f.let(f"add i64 {first}, {lane}"))

    f.each_lane(taken, take)
    f.spend(f.let("add i64 0, 1"), taken)
    f.values.clear()
    f.run(f.program.epilogue, taken)
    f.store_outputs()
    f.each_lane(taken, f.give_outputs)
    f.go("batch")


def _refilling(f: Walkers) -> None:
    """A function with a loop: see the top of this file."""
    f.go("refill")
    f.label("refill")  # every end of a walker leads here, and so does the beginning
    ended = f.let(f"phi {f.bits} [0, %entry], [%ended.first, %prologue.end], [%ended, %spend]")
    live = f.let(f"phi {f.bits} [0, %entry], [%active, %prologue.end], [%live, %spend]")
    f.branch(f.stopped(), "leave", "refill.go")
    f.label("refill.go")
    f.branch(f.let(f"icmp ne {f.bits} {ended}, 0"), "epilogue", "take")
    f.label("epilogue")
    f.values.clear()
    f.run(f.program.epilogue, ended)
    f.store_outputs()
    f.each_lane(ended, f.give_outputs)
    f.go("take")
    f.label("take")
    kept = f.let(f"and {f.bits} {live}, {f.let(f'xor {f.bits} {ended}, -1')}")
    new = f.take_walkers(f.let(f"xor {f.bits} {kept}, -1"))
    f.do(f"%active = or {f.bits} {kept}, {new}")
    f.branch(f.let(f"icmp ne {f.bits} {new}, 0"), "prologue", "idle")
    f.label("idle")
    f.branch(f.let(f"icmp ne {f.bits} {kept}, 0"), "steps", "leave")
    _prologue(f, new)
    _steps(f)


def _loop(f: Walkers) -> Turns:
    loop = f.program.loop
    if loop is None:
        raise ValueError("the program has no loop")
    return loop


def _prologue(f: Walkers, new: str) -> None:
    """Computes what steps and epilogue need of all lanes; starts the loop in new ones."""
    loop = _loop(f)
    f.label("prologue")
    f.values.clear()
    f.run(f.program.prologue, "%active")
    f.keep()
    starting = f.mask(new)
    for place, node in loop.initial.items():
        dtype = f.dtype(node)
        before = f.read(f.carried[place], dtype)
        f.write(f.carried[place], dtype, f.select(starting, f.value(node), before, dtype))
    goes_on = f.let(f"bitcast {f.vector('bool')} {f.value(loop.first)} to {f.bits}")
    stays = f.let(f"xor {f.bits} {goes_on}, -1")
    f.go("prologue.end")
    f.label("prologue.end")
    f.do(f"%ended.first = and {f.bits} {new}, {stays}")
    f.branch(f.let(f"icmp ne {f.bits} %ended.first, 0"), "refill", "steps")


def _steps(f: Walkers) -> None:
    """The hot loop: a step of all lanes, until a lane's walker ends."""
    loop = _loop(f)
    f.label("steps")
    f.do(f"%live = phi {f.bits} [%active, %prologue.end], [%active, %idle]")
    f.go("step")
    f.label("step")
    f.do("%done = phi i64 [0, %steps], [%done.more, %step.end]")
    f.values.clear()
    f.run(loop.body, "%live")
    following = [(f.carried[place], f.dtype(n), f.value(n)) for place, n in loop.following.items()]
    again = f.value(loop.again)
    for offset, dtype, value in following:
        f.write(offset, dtype, value)
    goes_on = f.let(f"bitcast {f.vector('bool')} {again} to {f.bits}")
    f.go("step.end")
    f.label("step.end")
    f.do(f"%ended = and {f.bits} %live, {f.let(f'xor {f.bits} {goes_on}, -1')}")
    f.do("%done.more = add i64 %done, 1")
    some = f.let(f"icmp ne {f.bits} %ended, 0")
    f.branch(f.either(some, f.stopped()), "spend", "step")
    f.label("spend")
    f.spend("%done.more", "%live")
    f.go("refill")
