"""Random programs compute what JAX computes of them, as far as rounding decides it.

`pytest tests/engines/lanes/test_random_programs.py --hypothesis-profile=thorough --dist=load` makes
some three thousand new ones.
"""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engines.lanes.programs.agreement import (
    KINDS,
    WIDE_KINDS,
    arguments,
    differing,
    disagreements,
)
from engines.lanes.programs.interpretation import OPERATIONS
from engines.lanes.programs.program import Block, Kind, Program, Step
from engines.lanes.programs.strategies import CONTROL, FAMILIES, programs
from hypothesis import given
from hypothesis import strategies as st

from mjxwalk.engines.lanes.backend import operations
from mjxwalk.engines.lanes.frontend import memory
from mjxwalk.engines.lanes.frontend.primitives import control_flow

BATCHES = st.lists(programs(KINDS), min_size=1, max_size=8)
WIDE_BATCHES = st.lists(programs(WIDE_KINDS), min_size=1, max_size=8)
BODY = Block((Kind("int32", (3,)),), (Step("shl", (10, 3)),), (11,))
BLOCKS = (Block((Kind("int32", (3,)),), (), (7,)), BODY)
BRANCHES = (Block((), (Step("sqrt", (0,)),), (10,)), Block((), (), (0,)))


@given(batch=BATCHES)
def test_random_programs_agree_with_jax(batch: Sequence[Program]) -> None:
    """Several programs are compiled at once, since compiling takes most of the time."""
    _agree(batch, KINDS)


@given(batch=BATCHES)
def test_random_programs_that_pass_over_branches_and_keep_arrays_agree_with_jax(
    batch: Sequence[Program],
) -> None:
    """Every branch is a loop of at most one turn, and products are loops over memory."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(control_flow, "WORTH_SKIPPING", 0)
        patch.setattr(memory, "LARGE_PRODUCT", 4)
        patch.setattr(memory, "LARGE_ARRAY", 2)
        _agree(batch, KINDS)


@given(batch=WIDE_BATCHES)
def test_random_programs_of_float64_agree_with_jax(batch: Sequence[Program]) -> None:
    with jax.enable_x64(True):
        _agree(batch, WIDE_KINDS)


def _agree(batch: Sequence[Program], kinds: Any) -> None:
    found = disagreements(batch, arguments(kinds))
    jax.clear_caches()  # compiled functions by the thousand
    assert not found, "\n".join(found)


def test_every_operation_can_be_drawn() -> None:
    assert {name for family in FAMILIES for name in family} == set(OPERATIONS)
    assert set(CONTROL).isdisjoint(OPERATIONS)


@pytest.mark.parametrize(
    "op, other, steps",
    [
        ("lt", "le", [Step("lt", (0, 0))]),
        ("max", "min", [Step("max", (0, 2))]),
        ("sar", "shr", [Step("sar", (3, 4))]),
        ("shl", "shr", [Step("while", (3,), (), BLOCKS)]),
        ("sqrt", "recip", [Step("branch", (4,), (), BRANCHES)]),
    ],
)
def test_a_fault_of_the_compiler_is_found(
    op: str, other: str, steps: Any, monkeypatch: Any
) -> None:
    program = Program(Block(KINDS, tuple(steps), (len(KINDS),)))
    assert not disagreements([program], arguments(KINDS))
    monkeypatch.setitem(operations.OPERATIONS, op, operations.OPERATIONS[other])
    found = disagreements([program], arguments(KINDS))
    assert found and repr(program) in found[0]


def test_numbers_may_differ_where_rounding_lets_them_and_nowhere_else() -> None:
    exact = np.array([[1.0], [2.0], [3.0], [np.nan], [5.0]], np.float32)
    other = np.array([[1.0], [2.0], [3.0], [np.nan], [6.0]], np.float32)
    got = np.array([[1.0], [2.1], [3.0000002], [0.0], [5.9]], np.float32)
    doubt = np.zeros(5, bool)
    assert differing(got, np.stack([exact, other]), doubt).tolist() == [1, 3]
    places = np.array([[1], [2], [3], [4], [5]])
    assert differing(places, np.stack([places, places + (places == 2)]), doubt).tolist() == []
    assert differing(places + (places < 3), np.stack([places, places]), doubt).tolist() == [0, 1]
    doubt[0] = True  # lanes promises nothing there
    assert differing(places + (places < 3), np.stack([places, places]), doubt).tolist() == [1]


def test_the_order_of_a_product_or_a_sum_decides_only_near_the_ends_of_its_type() -> None:
    for name, numbers in (("cumprod", [0, 3e38, -48]), ("prod", [1e-30, 1e-30, 1e30]),
                          ("sum", [3e38, 3e38, -3e38])):  # fmt: skip
        doubt = OPERATIONS[name].doubt
        assert doubt is not None
        x = jnp.array(numbers, jnp.float32)
        assert doubt([x], x) and not doubt([jnp.clip(x, 0.1, 50)], x)
