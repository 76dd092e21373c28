"""The scalar graph: what one walker computes, one number at a time, nothing twice.

A node is an operation on earlier nodes; its id is its place in the list, so ids are in dependency
order. Equal nodes are one node (hash-consing), which merges common subexpressions as the graph
grows. A loop is kept beside the list: its carried values enter the body as `carry` nodes and leave
it as `result` nodes. Whatever in a body does not depend on a `carry` of its loop is an invariant,
without anybody having to move it.
"""

import dataclasses
import functools
from collections.abc import Container, Iterable, Mapping
from typing import Any, NamedTuple, NewType, cast

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]  # any shape, any type: numbers, or ids of nodes

LoopId = NewType("LoopId", int)
OUTSIDE = LoopId(-1)  # the region outside every loop


class Node(NamedTuple):
    """One scalar value.

    An `inside` is its first argument, as a step of the loop of the second has it. `data`
    distinguishes nodes of equal operation and arguments: the bits of a `const`, (argument,
    offset) of an `input`, argument of a `load`, the table of a `lookup`, (loop, place) of a `carry`
    or `result`.
    """

    op: str
    dtype: str
    args: tuple[int, ...] = ()
    data: Any = None


@dataclasses.dataclass(kw_only=True)
class Loop:
    """A `while` over scalars: node ids of its values at the start, after a step, and its test.

    Attributes:
      parent: the region that the loop stands in, `OUTSIDE` or another loop.
      initial: value of each carry, by its place, before the first step.
      following: value of each carry after a step, computed from the `carry` nodes.
      condition: whether to take another step, computed from the `carry` nodes.
    """

    parent: LoopId
    initial: dict[int, int] = dataclasses.field(default_factory=dict[int, int])
    following: dict[int, int] = dataclasses.field(default_factory=dict[int, int])
    condition: int = -1

    def fill(self, other: "Loop", mapping: Mapping[int, int]) -> None:
        """Takes over the carries and the test of another loop that `mapping` knows of."""
        for place, first in other.initial.items():
            then = other.following[place]
            if first in mapping and then in mapping:
                self.initial[place], self.following[place] = mapping[first], mapping[then]
        self.condition = mapping[other.condition]


class Graph:
    """A growing list of distinct nodes, the loops they belong to, and constant tables."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self.loops: dict[LoopId, Loop] = {}
        self.tables: dict[str, Array] = {}
        self.ranges: dict[tuple[int, int], tuple[float, float]] = {}  # `bounds` keeps them here
        self._ids: dict[Node, int] = {}
        self._values: dict[int, Any] = {}

    def add(self, op: str, dtype: str, args: tuple[int, ...] = (), data: Any = None) -> int:
        """Returns the id of this node, which is new only if no equal one exists."""
        node = Node(op, dtype, args, data)
        found = self._ids.get(node)
        if found is None:
            found = self._ids[node] = len(self.nodes)
            self.nodes.append(node)
        return found

    def find(self, op: str, dtype: str, args: tuple[int, ...], data: Any) -> int | None:
        """Returns the id of a node if it exists."""
        return self._ids.get(Node(op, dtype, args, data))

    def constant(self, value: Any) -> int:
        """Returns the node of a known scalar; zeros of different sign and NaNs stay distinct."""
        found = self.add("const", _name(value.dtype), (), value.tobytes())
        self._values[found] = value
        return found

    def value(self, node: int) -> Any:
        """Returns the scalar that a node is known to be, or None."""
        return self._values.get(node)

    def dtype(self, node: int) -> str:
        """Returns the type of a node."""
        return self.nodes[node].dtype

    def new_loop(self, parent: LoopId) -> LoopId:
        """Returns a new loop with nothing in it yet."""
        loop = LoopId(len(self.loops))
        self.loops[loop] = Loop(parent=parent)
        return loop

    def table(self, array: Array) -> str:
        """Keeps a constant array that is indexed by data; equal arrays are kept once."""
        for known, kept in self.tables.items():
            if kept.dtype == array.dtype and np.array_equal(kept, array.ravel()):
                return known
        name = f"table{len(self.tables)}"
        self.tables[name] = np.ascontiguousarray(array).ravel()
        return name

    def __len__(self) -> int:
        return len(self.nodes)


@functools.cache
def _name(dtype: np.dtype[Any]) -> str:
    """Returns the name of a type, which NumPy puts together anew each time."""
    return dtype.name


def reachable(graph: Graph, roots: Iterable[int], stop: Container[int] = ()) -> list[int]:
    """Returns, in order, the nodes that `roots` need, not looking behind those in `stop`.

    A `result` needs its carry's value at the start and after a step, and its loop's test; a carry
    that nothing needs is dead and is not visited.
    """
    seen: set[int] = set()
    pending = list(roots)
    while pending:
        node_id = pending.pop()
        if node_id in seen:
            continue
        seen.add(node_id)
        if node_id in stop:
            continue
        node = graph.nodes[node_id]
        pending.extend(node.args)
        if node.op in ("carry", "result"):
            number, place = carried(node)
            loop = graph.loops[number]
            pending += (loop.initial[place], loop.following[place], loop.condition)
    return sorted(seen)


def carried(node: Node) -> tuple[LoopId, int]:
    """Returns (loop, place) of a `carry` or `result` node."""
    return cast(tuple[LoopId, int], node.data)


def regions(graph: Graph, live: Iterable[int]) -> dict[int, LoopId]:
    """Returns the innermost loop whose carries each live node depends on, or `OUTSIDE`."""
    depth = {OUTSIDE: 0}
    for number, loop in graph.loops.items():
        depth[number] = depth[loop.parent] + 1
    region: dict[int, LoopId] = {}
    for node_id in live:
        node = graph.nodes[node_id]
        if node.op == "carry":
            region[node_id] = carried(node)[0]
        elif node.op == "result":
            region[node_id] = graph.loops[carried(node)[0]].parent
        else:
            region[node_id] = max(
                (region[arg] for arg in node.args), key=depth.__getitem__, default=OUTSIDE
            )
    return region
