"""The arithmetic peak of the CPU's vector units, measured with fused multiply-adds."""

import ctypes
import threading
from typing import Any

import llvmlite.binding as _llvm

from mjxwalk.engines.lanes.backend import machine_code

llvm: Any = _llvm  # untyped

# ours: two units that take four or five cycles need ten chains, the four of some ARM cores need
# sixteen; more than registers would spill.
CHAINS = 12  # of sixteen registers
CHAINS_OF_MANY = 24  # of thirty-two: AVX-512 and ARM64
OPERATIONS_A_LANE = 2  # a multiplication and an addition


class Peak:
    """A contender that multiplies and adds in registers, on every thread.

    Attributes:
      width: lanes of a vector, those that the lanes engine uses.
      threads: how many run at once.
      chains: of multiply-adds that do not wait for each other.
    """

    def __init__(self, threads: int, width: int | None = None) -> None:
        host = machine_code.host(width)
        self.width = host.width
        self.threads = threads
        many = host.width == 16 or host.processor in ("aarch64", "arm64")
        self.chains = CHAINS_OF_MANY if many else CHAINS
        machine = llvm.Target.from_default_triple().create_target_machine(
            cpu=host.cpu, features=host.features, opt=2, reloc="pic", codemodel="small"
        )
        module = llvm.parse_assembly(_source(host.width, self.chains))
        module.verify()
        self._engine = llvm.create_mcjit_compiler(module, machine)
        self._engine.finalize_object()
        kind = ctypes.CFUNCTYPE(ctypes.c_float, ctypes.c_int64, ctypes.c_float, ctypes.c_float)
        self._call = kind(self._engine.get_function_address("peak"))

    def __call__(self, rounds: int) -> int:
        """Goes through the chains on every thread and returns how many operations that took."""
        turns = max(1, rounds) * 1000  # a thread takes longer to start than a turn
        crew = [
            threading.Thread(target=self._call, args=(turns, 0.999, 0.001))
            for _ in range(self.threads)
        ]
        for worker in crew:
            worker.start()
        for worker in crew:
            worker.join()
        return turns * self.chains * self.width * OPERATIONS_A_LANE * self.threads


def _source(width: int, number: int) -> str:
    """Returns LLVM IR of independent chains x = x * scale + offset, in a loop.

    `contract` fuses them where the CPU can; elsewhere its peak is without fusing.
    """
    vector = f"<{width} x float>"
    chains = range(number)
    spread = "".join(
        f"  %{name}1 = insertelement {vector} poison, float %{name}, i32 0\n"
        f"  %{name}s = shufflevector {vector} %{name}1, {vector} poison, "
        f"<{width} x i32> zeroinitializer\n"
        for name in ("scale", "offset")
    )
    starts = "".join(
        f"  %x{n} = phi {vector} [ {_constant(width, n)}, %entry ], [ %y{n}, %turn ]\n"
        for n in chains
    )
    steps = "".join(
        f"  %m{n} = fmul contract {vector} %x{n}, %scales\n"
        f"  %y{n} = fadd contract {vector} %m{n}, %offsets\n"
        for n in chains
    )
    sums = "".join(
        f"  %t{n} = fadd {vector} {'%y0' if n == 1 else f'%t{n - 1}'}, %y{n}\n"
        for n in chains
        if n > 0
    )
    return (
        f"define float @peak(i64 %turns, float %scale, float %offset) {{\nentry:\n{spread}"
        f"  br label %turn\nturn:\n"
        f"  %i = phi i64 [ 0, %entry ], [ %next, %turn ]\n{starts}{steps}"
        f"  %next = add i64 %i, 1\n  %more = icmp slt i64 %next, %turns\n"
        f"  br i1 %more, label %turn, label %end\nend:\n{sums}"
        f"  %first = extractelement {vector} %t{number - 1}, i32 0\n  ret float %first\n}}\n"
    )


def _constant(width: int, number: int) -> str:
    # Chains that start alike could be merged into one.
    return "<" + ", ".join(f"float {number + 1}.0" for _ in range(width)) + ">"
