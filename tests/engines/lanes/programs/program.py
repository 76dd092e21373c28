"""Small programs as data: what the random ones are made of, and their text.

A program is a block whose inputs are a walker's arguments. Values are numbered in the order in
which they come to be; a block inside another sees the values around it and numbers its own after
them.
"""

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple


class Kind(NamedTuple):
    """What type of numbers a value holds, and how many."""

    dtype: str
    shape: tuple[int, ...]

    def __str__(self) -> str:
        return f"{self.dtype}[{','.join(map(str, self.shape))}]"


@dataclasses.dataclass(frozen=True)
class Step:
    """An operation on values made before.

    Attributes:
      args: numbers of the values it reads.
      params: plain numbers and words that are fixed when the program is made.
      blocks: bodies of a loop or the branches of a choice.
      makes: how many values it makes.
    """

    op: str
    args: tuple[int, ...] = ()
    params: tuple[Any, ...] = ()
    blocks: "tuple[Block, ...]" = ()
    makes: int = 1


@dataclasses.dataclass(frozen=True)
class Block:
    """Steps one after the other.

    Attributes:
      inputs: kinds of the values that it is given.
      outputs: numbers of the values that it returns.
    """

    inputs: tuple[Kind, ...]
    steps: tuple[Step, ...]
    outputs: tuple[int, ...]


@dataclasses.dataclass(frozen=True, repr=False)
class Program:
    """A block that stands alone; its text is what a failing test shows."""

    block: Block

    def __repr__(self) -> str:
        return "\n".join(_lines(self.block, 0, ""))


def unread(block: Block, first: int) -> list[int]:
    """Returns the numbers of the values that a block makes and no step of it reads.

    Args:
      first: the number of the block's first input.
    """
    read = {arg for step in block.steps for arg in _reads(step)}
    start = first + len(block.inputs)
    end = start + sum(step.makes for step in block.steps)
    return [number for number in range(start, end) if number not in read]


def _reads(step: Step) -> Iterator[int]:
    yield from step.args
    for block in step.blocks:
        yield from block.outputs
        for inner in block.steps:
            yield from _reads(inner)


def _lines(block: Block, first: int, indent: str) -> Iterator[str]:
    """Returns a block's text, a step a line."""
    numbers = range(first, first + len(block.inputs))
    given = ", ".join(f"v{n}: {kind}" for n, kind in zip(numbers, block.inputs, strict=True))
    yield f"{indent}given ({given})"
    number = first + len(block.inputs)
    for step in block.steps:
        made = _names(range(number, number + step.makes))
        given = ", ".join([_names(step.args), *map(repr, step.params)])
        yield f"{indent}{made} = {step.op}({given})"
        for inner in step.blocks:
            yield from _lines(inner, number, indent + "  ")
        number += step.makes
    yield f"{indent}return {_names(block.outputs)}"


def _names(numbers: Sequence[int]) -> str:
    return ", ".join(f"v{number}" for number in numbers)
