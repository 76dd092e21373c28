"""Tests of scripts/instruction_mix.py."""

import pytest
import scripted

kind_of = scripted.load("instruction_mix").kind_of


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
def test_instructions_are_told_apart(instruction: str, kind: str) -> None:
    assert kind_of(instruction) == kind
