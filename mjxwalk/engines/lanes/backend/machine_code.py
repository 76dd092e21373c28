"""The host CPU, and machine code for it."""

import ctypes
import os
import platform
from typing import Any

import llvmlite.binding as llvm  # untyped; used in this file only

from mjxwalk.engines.lanes.backend.target import Target

WIDTHS = (4, 8, 16)
LONG = 1 << 20  # characters of LLVM IR; ours: some 15,000 operations


def host(width: int | None = None) -> Target:
    """Returns the host CPU as a target.

    Args:
      width: lanes of a vector; None asks MJXWALK_LANES_WIDTH, then takes what the CPU is best at.
    """
    _initialise()
    features: dict[str, bool] = dict(llvm.get_host_cpu_features())
    if width is None:
        asked = os.environ.get("MJXWALK_LANES_WIDTH")
        width = int(asked) if asked else _best_width(features)
    if width not in WIDTHS:
        raise ValueError(f"width must be one of {WIDTHS}, got {width}")
    named = ",".join(f"{'+' if has else '-'}{name}" for name, has in sorted(features.items()))
    if width == 16 and features.get("avx512f"):
        named += ",-prefer-256-bit"
    processor = platform.machine().lower().replace("amd64", "x86_64")
    if processor in ("aarch64", "arm64"):
        # With SVE, LLVM keeps what has no register in slots whose size the CPU alone knows, and
        # computes the address of most of them.
        named = ",".join([named, "-sve"]).lstrip(",")
    return Target(
        width=width,
        processor=processor,
        cpu=llvm.get_host_cpu_name(),
        features=named,
        estimates=width == 16 and features.get("avx512f", False),
    )


def _best_width(features: dict[str, bool]) -> int:
    if features.get("avx512f"):
        return 16
    return 8 if features.get("avx2") else 4


def _initialise() -> None:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


def _machine(target: Target) -> Any:
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=target.cpu, features=target.features, opt=2, reloc="pic", codemodel="small"
    )


def assemble(text: str, target: Target) -> bytes:
    """Returns the object code of LLVM IR."""
    return bytes(_machine(target).emit_object(_optimised(text, target)))


def assembly(text: str, target: Target) -> str:
    """Returns the assembly of LLVM IR, for reading."""
    return str(_machine(target).emit_assembly(_optimised(text, target)))


def _optimised(text: str, target: Target) -> Any:
    _initialise()
    module = llvm.parse_assembly(text)
    module.verify()
    # What is long is straight-line code, which LLVM's passes no longer make faster.
    level = 0 if len(text) > LONG else 1
    options = llvm.create_pipeline_tuning_options(speed_level=level)
    options.loop_vectorization = False
    options.slp_vectorization = False
    options.loop_unrolling = False
    builder = llvm.create_pass_builder(_machine(target), options)
    builder.getModulePassManager().run(module, builder)
    return module


class Loaded:
    """Object code in memory, ready to be called."""

    def __init__(self, code: bytes) -> None:
        _initialise()
        # JITLink keeps a kernel's code and constants in one piece of memory. MCJIT asks for each by
        # itself, and aborts where another thread got the memory between: they reach 2 GiB only.
        self._linker: Any = llvm.create_lljit_compiler(use_jit_link=True)
        builder: Any = llvm.JITLibraryBuilder()
        builder.add_object_img(code).add_current_process().export_symbol("lanes")
        self._library: Any = builder.link(self._linker, "lanes")
        pointer, number = ctypes.c_void_p, ctypes.c_int64
        kind = ctypes.CFUNCTYPE(None, pointer, pointer, pointer, number, pointer, pointer, pointer)
        self.call = kind(self._library["lanes"])
