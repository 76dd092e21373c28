"""PTX, the assembly language of NVIDIA's GPUs, from a program: one walker a thread.

PTX is made by LLVM alone; a GPU's driver makes machine code of it. How PTX uses the instructions:
NVIDIA, "Parallel Thread Execution ISA", https://docs.nvidia.com/cuda/parallel-thread-execution.
"""

from collections.abc import Sequence
from typing import Any

import llvmlite.binding as llvm  # untyped

from mjxwalk.engines.lanes.backend.target import Target
from mjxwalk.engines.lanes.backend.thread_kernel import Frame, emit_thread_kernel
from mjxwalk.engines.lanes.ir.program import Program
from mjxwalk.engines.lanes.ir.signature import Argument, Result

TRIPLE = "nvptx64-nvidia-cuda"
ENTRY = "lanes"  # name of the kernel; its parameters are a pointer to each array, and the count
THREADS = 64  # of a block; ours: few, so that small populations spread over all processors
# Ampere's, the oldest whose `max` passes NaN on; drivers compile it for all that came later.
ARCHITECTURE = "sm_80"
FEATURES = "+ptx71"
_IDENTITY = "llvm.nvvm.read.ptx.sreg"


def target() -> Target:
    """Returns the GPU that PTX is made for."""
    return Target(
        width=1, processor="nvptx64", cpu=ARCHITECTURE, features=FEATURES, estimates=False
    )


def emit_ptx(program: Program, arguments: Sequence[Argument], results: Sequence[Result]) -> str:
    """Returns the PTX of a program."""
    text = emit_thread_kernel(program, arguments, results, target(), _frame(arguments, results))
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine: Any = llvm.Target.from_triple(TRIPLE).create_target_machine(
        cpu=ARCHITECTURE, features=FEATURES, opt=2
    )
    module: Any = llvm.parse_assembly(text)
    module.triple = TRIPLE
    module.data_layout = str(machine.target_data)
    module.verify()
    options: Any = llvm.create_pipeline_tuning_options(speed_level=1)
    options.loop_unrolling = False
    builder: Any = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return str(machine.emit_assembly(module))


def _frame(arguments: Sequence[Argument], results: Sequence[Result]) -> Frame:
    """Returns the kernel around a walker's code: its number is that of its thread."""
    pointer = "ptr addrspace(1)"
    given = [f"{pointer} noalias readonly align 16 %input.{n}" for n in range(len(arguments))]
    taken = [f"{pointer} noalias align 16 %output.{n}" for n in range(len(results))]
    head = [
        *(f"declare i32 @{_IDENTITY}.{name}.x()" for name in ("ctaid", "ntid", "tid")),
        f"define ptx_kernel void @{ENTRY}({', '.join([*given, *taken, 'i64 %count'])}) #0 {{",
        "entry:",
    ]
    start = [
        *(f"  %{name} = call i32 @{_IDENTITY}.{name}.x()" for name in ("ctaid", "ntid", "tid")),
        "  %first = mul i32 %ctaid, %ntid",
        "  %thread = add i32 %first, %tid",
        "  %walker = zext i32 %thread to i64",
        "  %is_one = icmp ult i64 %walker, %count",
        "  br i1 %is_one, label %walk, label %end",
        "walk:",
    ]
    attributes = f'"denormal-fp-math-f32"="preserve-sign" "nvvm.maxntid"="{THREADS}"'
    tail = ["end:", "  ret void", "}", f"attributes #0 = {{ {attributes} }}"]
    return Frame(pointer=pointer, space="addrspace(1) ", head=head, start=start, tail=tail)
