"""Which arrays stay arrays: those of large matrix products, and what is computed from them.

An array of ids is in memory if its ids say so: numbers of an input are counted from `ARGUMENT` on,
and elements of an array have consecutive ids, so that a transposed or a broadcast array is
recognised as well.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mjxwalk.engines.lanes.ir.arrays import Elementwise, Product, View, num_elements
from mjxwalk.engines.lanes.ir.graph import Array, Graph

# Elements of inputs are numbered from here: argument * ARGUMENT + place, so that a table of a
# million entries costs no nodes, and rows of it are recognised by their consecutive numbers.
ARGUMENT = 1 << 40

LARGE_PRODUCT = 1024  # multiplications from which a product is a loop; ours: fewer are as fast
LARGE_ARRAY = 32  # numbers from which what is computed of a product is a loop too; ours
FEW_ROWS = 4  # of a product's smaller side, which are summed side by side; ours


class Place(NamedTuple):
    """Where an array's numbers are in memory: an argument or a node, and even steps."""

    is_input: bool
    source: int
    first: int
    strides: tuple[int, ...]


def place(graph: Graph, ids: Array) -> Place | None:
    """Returns where in memory an array's numbers are, or None if they are anywhere else."""
    if ids.size == 0:
        return None
    first = int(ids.flat[0])
    strides = tuple(
        int(np.take(ids, 1, axis).flat[0]) - first if size > 1 else 0
        for axis, size in enumerate(ids.shape)
    )
    even = np.full((), first, np.int64)
    for size, stride in zip(ids.shape, strides, strict=True):
        even = even[..., None] + stride * np.arange(size)
    if not np.array_equal(even, ids):
        return None
    ends = int(ids.min()), int(ids.max())
    if first >= ARGUMENT:
        argument = (ends[0] - ARGUMENT) // ARGUMENT
        if argument != (ends[1] - ARGUMENT) // ARGUMENT:
            return None
        return Place(True, argument, (first - ARGUMENT) % ARGUMENT, strides)
    nodes = [graph.nodes[end] for end in ends] if ends[1] < ARGUMENT else []
    if not nodes or any(node.op != "element" for node in nodes):
        return None
    if nodes[0].args != nodes[1].args:
        return None
    return Place(False, nodes[0].args[0], graph.nodes[first].data, strides)


def matrix_product(graph: Graph, left: Array, right: Array, dtype: str) -> Array | None:
    """Returns ids [i, j] of the sums over k of left[i, k] right[j, k], if a loop computes them."""
    (rows, terms), columns = left.shape, right.shape[0]
    if rows * columns * terms < LARGE_PRODUCT:
        return None
    if rows > columns:
        found = matrix_product(graph, right, left, dtype)
        return None if found is None else found.T
    matrix = place(graph, right)
    if matrix is None or rows > FEW_ROWS or min(matrix.strides) < 0:
        return None
    reads = _Reads(graph)
    product = Product((rows, columns, terms), reads.view(left, dtype), reads.of_place(matrix))
    made = graph.add("product", dtype, tuple(reads.args), product)
    return elements(graph, made).reshape(rows, columns)


def elementwise(
    graph: Graph, op: str, dtype: str, operands: Sequence[Array], dtypes: Sequence[str]
) -> Array:
    """Returns ids of an operation on arrays of one shape, which a loop computes.

    Args:
      operands: ids.
      dtypes: of the operands.
    """
    reads = _Reads(graph)
    found = tuple(reads.view(*each) for each in zip(operands, dtypes, strict=True))
    shape = operands[0].shape
    made = graph.add(
        "elementwise", dtype, tuple(reads.args), Elementwise(shape, op, found, tuple(dtypes))
    )
    return elements(graph, made).reshape(shape)


def is_array(graph: Graph, ids: Array) -> bool:
    """Returns whether an array is large and was computed by a loop."""
    if ids.size < LARGE_ARRAY or int(ids.flat[0]) >= ARGUMENT:
        return False
    return graph.nodes[int(ids.flat[0])].op == "element" and place(graph, ids) is not None


def elements(graph: Graph, made: int) -> Array:
    """Returns the ids of an array's numbers, which are consecutive."""
    dtype, size = graph.dtype(made), num_elements(graph.nodes[made])
    ids = [graph.add("element", dtype, (made,), number) for number in range(size)]
    return np.array(ids, np.int64)


def node(graph: Graph, number: int, dtype: str) -> int:
    """Returns the node of a number of an array, which for one of an input is made on first use."""
    if number < ARGUMENT:
        return number
    return graph.add("input", dtype, (), divmod(number - ARGUMENT, ARGUMENT))


class _Reads:
    """What a node reads: the nodes that become its args, and views of them."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.args: list[int] = []

    def view(self, ids: Array, dtype: str) -> View:
        """Returns a view of numbers; puts them into memory if they are not there."""
        found = place(self.graph, ids)
        if found is not None and any(found.strides):
            return self.of_place(found)
        # What is the same along an axis is kept once.
        once = ids
        for axis in range(ids.ndim):
            row = once.take([0], axis)
            once = row if bool((once == row).all()) else once
        numbers = [node(self.graph, each, dtype) for each in once.ravel().tolist()]
        if len(numbers) == 1:
            return View("value", self._arg(numbers[0]), 0, (0,) * ids.ndim)
        values = [self.graph.value(number) for number in numbers]
        if all(value is not None for value in values):
            return View("table", self.graph.table(np.array(values, dtype)), 0, _strides(once))
        made = self.graph.add("array", dtype, tuple(numbers))
        return View("array", self._arg(made), 0, _strides(once))

    def of_place(self, found: Place) -> View:
        """Returns a view of numbers that are in memory."""
        if found.is_input:
            return View("input", found.source, found.first, found.strides)
        return View("array", self._arg(found.source), found.first, found.strides)

    def _arg(self, made: int) -> int:
        """Returns the place of a node among the args."""
        if made not in self.args:
            self.args.append(made)
        return self.args.index(made)


def _strides(array: Array) -> tuple[int, ...]:
    """Returns how far apart numbers along each axis are in memory; 0 along axes of one."""
    steps = (int(np.prod(array.shape[axis + 1 :])) for axis in range(array.ndim))
    return tuple(step if size > 1 else 0 for step, size in zip(steps, array.shape, strict=True))
