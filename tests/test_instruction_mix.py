"""Tests of scripts/instruction_mix.py."""

import importlib.util
from pathlib import Path
from typing import Any

import pytest

SCRIPT = Path(__file__).parents[1] / "scripts" / "instruction_mix.py"


@pytest.fixture(scope="module")
def script() -> Any:
    spec = importlib.util.spec_from_file_location("instruction_mix", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("instruction", "kind"),
    [
        ("vfmadd213ps", "multiply-add"),
        ("vfnmsub132ps", "multiply-add"),
        ("vmulps", "other arithmetic"),
        ("vrsqrt14ps", "other arithmetic"),
        ("vminps", "other arithmetic"),
        ("vcmpltps", "comparison, choice"),
        ("vblendvps", "comparison, choice"),
        ("vbroadcastss", "constant from memory"),
        ("vmovups", "load, store, move"),
        ("vpaddd", "integer"),
        ("jne", "scalar: addresses, jumps"),
        ("addq", "scalar: addresses, jumps"),
    ],
)
def test_instructions_are_told_apart(script: Any, instruction: str, kind: str) -> None:
    assert script.kind_of(instruction) == kind
