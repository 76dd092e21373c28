"""Code for ARM64, made on a machine of any kind."""

import platform
import re
from typing import Any

import jax.numpy as jnp
import llvmlite.binding as llvm  # untyped
import numpy as np
import pytest
from arm64 import assembly

from mjxwalk.engines import lanes_ptx
from mjxwalk.engines.lanes.backend import machine_code


@pytest.fixture
def graviton(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Returns the host as a target, were it a Neoverse V1, which has SVE."""
    monkeypatch.delenv("MJXWALK_LANES_WIDTH", raising=False)
    monkeypatch.setattr(platform, "machine", lambda: "aarch64")
    monkeypatch.setattr(llvm, "get_host_cpu_name", lambda: "neoverse-v1")
    monkeypatch.setattr(llvm, "get_host_cpu_features", lambda: {"neon": True, "sve": True})
    return machine_code.host()


def crowded(x: Any) -> Any:
    """Is more numbers than there are registers, all of them needed until the end."""
    made = [jnp.sqrt(x[n]) * x[(n + 7) % 50] - x[(n + 3) % 50] for n in range(50)]
    total = sum(made)
    return [each / total for each in made]


def test_what_has_no_register_lies_at_a_known_place(graviton: Any) -> None:
    lowered = lanes_ptx.lower(crowded, 0, np.zeros((4, 50), np.float32))
    width, cpu = graviton.width, graviton.cpu
    code = assembly.assembly(lowered, width, cpu, graviton.features)
    assert width == 4 and assembly.count(code.splitlines()).reloads > 10
    assert "addvl" not in code
    assert "addvl" in assembly.assembly(lowered, width, cpu, "+neon,+sve")


def test_the_extreme_of_two_numbers_is_one_instruction() -> None:
    def extremes(x: Any) -> Any:
        return jnp.maximum(x[0], x[1]), jnp.minimum(x[0], x[1])

    code = assembly.assembly(lanes_ptx.lower(extremes, 0, np.zeros((4, 2), np.float32)), 4)
    assert len(re.findall(r"\tfmax\t", code)) == len(re.findall(r"\tfmin\t", code)) == 1
    assert "fcm" not in code and "bsl" not in code


def test_instructions_spills_and_reloads_are_counted() -> None:
    code = """kernel:
\tstr\tx19, [sp]  // 8-byte Spill
.LBB0_1:
\t.p2align\t4
\tldr\tq0, [sp, #16]  // 16-byte Folded Reload
\tfadd\tv0.4s, v0.4s, v1.4s
\tstr\tq0, [sp, #16]  // 16-byte Spill
\tb\t.LBB0_1
.LBB0_2:
\tret"""
    assert assembly.count(assembly.step(code)) == (4, 1, 1)
