"""What a kernel does for a walker: what runs once, what every step runs, and in which order.

The loop that does most of the work is the program's own: its lanes are refilled when their walker
ends. What depends on no step of it is the prologue, what depends on its results the epilogue.
"""

import dataclasses
from collections.abc import Iterable

from mjxwalk.engines.lanes.ir.arrays import cost
from mjxwalk.engines.lanes.ir.graph import Graph, LoopId


@dataclasses.dataclass(frozen=True, kw_only=True)
class RotatedLoop:
    """A loop as machine code has it: a test before the first step and one after every step.

    Attributes:
      carries: node that the body reads for each carry, by place.
      initial, following: node of each carry's value at the start and after a step, by place.
      first_test: whether to take a first step, computed from `initial`.
      next_test: whether to take another step, computed from `following`.
      body: what a step computes, in order.
      external_inputs: nodes defined outside the loop that its body, tests or start read.
    """

    id: LoopId
    carries: dict[int, int]
    initial: dict[int, int]
    following: dict[int, int]
    first_test: int
    next_test: int
    body: "tuple[Step, ...]"
    external_inputs: frozenset[int]


Step = int | RotatedLoop  # a node to compute, or a loop to run


@dataclasses.dataclass(frozen=True, kw_only=True)
class Program:
    """What a kernel does for a walker.

    Attributes:
      loop: the loop with refilled lanes, or None.
      prologue, epilogue: steps before and after it.
      outputs: node of every output number, in order.
    """

    graph: Graph
    outputs: tuple[int, ...]
    prologue: tuple[Step, ...]
    loop: RotatedLoop | None
    epilogue: tuple[Step, ...]

    @property
    def num_operations(self) -> int:
        """How many scalar operations a step of the loop takes, or all of it without a loop."""
        return size(self.graph, self.loop.body if self.loop else self.epilogue)


def needs_of(graph: Graph, step: Step) -> Iterable[int]:
    """Returns the nodes that a step reads."""
    return step.external_inputs if isinstance(step, RotatedLoop) else graph.nodes[step].args


def size(graph: Graph, steps: Iterable[Step]) -> int:
    """Returns how many scalar operations some steps take, a step of each loop within them."""
    return sum(
        size(graph, step.body) if isinstance(step, RotatedLoop) else cost(graph, step)
        for step in steps
    )
