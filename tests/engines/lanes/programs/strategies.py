"""Hypothesis makes programs: a step at a time, each of the values that there are by then."""

import functools
from collections.abc import Callable, Sequence
from typing import Any

import jax
import numpy as np
from engines.lanes.programs.array_operations import PLACES, PRODUCTS, REDUCTIONS, SHAPES
from engines.lanes.programs.interpretation import OPERATIONS
from engines.lanes.programs.operations import (
    CHOOSING,
    ELEMENTWISE,
    FUNCTIONS,
    Draw,
    Impossible,
    pick,
)
from engines.lanes.programs.program import Block, Kind, Program, Step, unread
from hypothesis import strategies as st

FAMILIES: list[Sequence[str]] = [list(family) for family in (
    ELEMENTWISE, ELEMENTWISE, FUNCTIONS, CHOOSING, SHAPES, REDUCTIONS, PRODUCTS, PLACES,
)]  # fmt: skip
MOST_NUMBERS = 36  # in one value


@st.composite
def programs(draw: Draw, inputs: tuple[Kind, ...], most_steps: int = 9, depth: int = 2) -> Program:
    """Returns programs of these inputs; they return all that no step reads."""
    steps, kinds = _steps(draw, inputs, draw(st.integers(1, most_steps)), depth)
    block = Block(inputs, steps, ())
    outputs = unread(block, 0) or [len(kinds) - 1]
    return Program(Block(inputs, steps, tuple(outputs)))


def _steps(
    draw: Draw, kinds: Sequence[Kind], count: int, depth: int
) -> tuple[tuple[Step, ...], list[Kind]]:
    """Returns up to `count` steps on values of these kinds, and these kinds with the steps' own."""
    steps: list[Step] = []
    known = list(kinds)
    for _ in range(count):
        try:
            step, made = _step(draw, known, depth)
        except Impossible:
            continue
        steps.append(step)
        known += made
    return tuple(steps), known


def _step(draw: Draw, kinds: Sequence[Kind], depth: int) -> tuple[Step, list[Kind]]:
    families = [*FAMILIES, list(CONTROL), list(CONTROL)] if depth else FAMILIES
    name = draw(st.sampled_from(draw(st.sampled_from(families))))
    if name in CONTROL:
        return CONTROL[name](draw, kinds, depth - 1)
    args, params = OPERATIONS[name].choose(draw, kinds)
    wide = any(kind.dtype.endswith("64") for kind in kinds)
    made = _kind(name, params, tuple(kinds[arg] for arg in args), wide)
    return Step(name, args, params), [made]


@functools.cache
def _kind(name: str, params: tuple[Any, ...], args: tuple[Kind, ...], wide: bool) -> Kind:
    """Returns what an operation makes of arguments of these kinds.

    Raises:
      Impossible: it takes no such arguments, or makes nothing or too much of them.
    """
    structs = [jax.ShapeDtypeStruct(kind.shape, np.dtype(kind.dtype)) for kind in args]
    try:
        with jax.enable_x64(wide):
            made = jax.eval_shape(lambda *xs: OPERATIONS[name].run(params, *xs), *structs)
    except (TypeError, ValueError) as error:
        raise Impossible(name) from error
    if not 0 < made.size <= MOST_NUMBERS:
        raise Impossible(name)
    return Kind(made.dtype.name, made.shape)


def _block(
    draw: Draw, around: Sequence[Kind], inputs: Sequence[Kind], wanted: Sequence[Kind], depth: int
) -> Block:
    """Returns a block with outputs of the wanted kinds.

    Raises:
      Impossible: it has no values of one of them.
    """
    scope = [*around, *inputs]
    steps, kinds = _steps(draw, scope, draw(st.integers(0, 4)), depth)
    outputs = [pick(draw, kinds, lambda k, kind=kind: k == kind) for kind in wanted]
    return Block(tuple(inputs), steps, tuple(outputs))


def _carried(draw: Draw, kinds: Sequence[Kind]) -> tuple[int, ...]:
    return tuple(pick(draw, kinds, lambda k: True) for _ in range(draw(st.integers(1, 3))))


def _turns(draw: Draw, kinds: Sequence[Kind], depth: int) -> tuple[Step, list[Kind]]:
    fixed = draw(st.sampled_from([3, 1, None]))
    number = () if fixed is not None else (pick(draw, kinds, lambda k: k == Kind("int32", ())),)
    carried = _carried(draw, kinds)
    made = [kinds[n] for n in carried]
    body = _block(draw, kinds, [Kind("int32", ()), *made], made, depth)
    return Step("turns", (*number, *carried), (fixed,), (body,), len(made)), made


def _while(draw: Draw, kinds: Sequence[Kind], depth: int) -> tuple[Step, list[Kind]]:
    carried = _carried(draw, kinds)
    made = [kinds[n] for n in carried]
    test = _block(draw, kinds, made, [Kind("bool", ())], depth)
    body = _block(draw, kinds, made, made, depth)
    return Step("while", carried, (), (test, body), len(made)), made


def _scan(draw: Draw, kinds: Sequence[Kind], depth: int) -> tuple[Step, list[Kind]]:
    x = pick(draw, kinds, lambda k: len(k.shape) > 0 and k.shape[0] < 7)
    y = pick(draw, kinds, lambda k: len(k.shape) > 0 and k.shape[0] == kinds[x].shape[0])
    carried, rows = _carried(draw, kinds), (x, y)
    state = [kinds[n] for n in carried]
    inputs = [*state, *(Kind(kinds[n].dtype, kinds[n].shape[1:]) for n in rows)]
    row = draw(st.sampled_from(inputs))
    body = _block(draw, kinds, inputs, [*state, row], depth)
    made = [*state, Kind(row.dtype, (kinds[x].shape[0], *row.shape))]
    params = (draw(st.booleans()), len(carried))
    return Step("scan", (*carried, *rows), params, (body,), len(made)), made


def _branch(draw: Draw, kinds: Sequence[Kind], depth: int) -> tuple[Step, list[Kind]]:
    which = pick(draw, kinds, lambda k: k.dtype in ("bool", "int32") and k.shape == ())
    wanted = [kinds[n] for n in _carried(draw, kinds)]
    count = 2 if kinds[which].dtype == "bool" else draw(st.integers(1, 3))
    blocks = tuple(_block(draw, kinds, (), wanted, depth) for _ in range(count))
    return Step("branch", (which,), (), blocks, len(wanted)), wanted


CONTROL: dict[str, Callable[..., tuple[Step, list[Kind]]]] = {
    "turns": _turns, "while": _while, "scan": _scan, "branch": _branch
}  # fmt: skip
