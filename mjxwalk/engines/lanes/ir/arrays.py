"""Arrays that stay arrays: one node each, computed by loops in memory.

All else in a graph is a scalar. An `array` puts scalars into memory, a `product` and an
`elementwise` compute arrays from arrays, and an `element` is a number of one, again a scalar. Each
of the first three has memory of its own; `data` of a node says what it reads and from where.
"""

import math
from typing import NamedTuple

from mjxwalk.engines.lanes.ir.graph import Graph, Node

IN_MEMORY = frozenset(["array", "product", "elementwise"])


class View(NamedTuple):
    """Numbers that a loop reads: the one at [i, j, ...] is at `first + i strides[0] + ...`.

    Attributes:
      kind: "input", "array", "table" of constants, or "value", a scalar.
      source: argument; place among the node's args; name of the table; place among the node's args.
    """

    kind: str
    source: int | str
    first: int
    strides: tuple[int, ...]


class Product(NamedTuple):
    """Sums over k of left[i, k] right[j, k], for every i and j; rows i are few."""

    shape: tuple[int, int, int]  # i, j, k
    left: View
    right: View


class Elementwise(NamedTuple):
    """An operation on each number of arrays of one shape."""

    shape: tuple[int, ...]
    op: str
    operands: tuple[View, ...]
    dtypes: tuple[str, ...]  # of the operands


def num_elements(node: Node) -> int:
    """Returns how many numbers a node has in memory."""
    if node.op == "array":
        return len(node.args)
    shape = node.data.shape[:2] if node.op == "product" else node.data.shape
    return math.prod(shape)


def views(node: Node) -> tuple[View, ...]:
    """Returns what a node's loops read."""
    if node.op == "product":
        return node.data.left, node.data.right
    return node.data.operands if node.op == "elementwise" else ()


def cost(graph: Graph, node_id: int) -> int:
    """Returns how many scalar operations a node stands for."""
    node = graph.nodes[node_id]
    if node.op == "product":
        return 2 * math.prod(node.data.shape)
    return num_elements(node) if node.op in IN_MEMORY else 1
