"""Adds nodes to a graph, simplified as it grows."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from mjxwalk.engines.lanes.ir.graph import OUTSIDE, Graph, LoopId
from mjxwalk.engines.lanes.ir.semantics import COMMUTATIVE, evaluate


class GraphBuilder:
    """Adds nodes to a graph, simplified by rules.

    A rule takes the builder, the type, the arguments and those of their values that are known, and
    returns a node that does as well, or None. What has no rule is not computed with: inputs, loads.
    """

    def __init__(self, graph: Graph, rules: Mapping[str, "Rule"]) -> None:
        self.graph = graph
        self.rules = rules
        self._constants: dict[tuple[str, str, tuple[int, ...]], int] = {}

    def make(self, op: str, dtype: str, args: tuple[int, ...], data: Any = None) -> int:
        """Returns a node equal to the operation on args, simplified as far as the rules go."""
        rule = self.rules.get(op)
        if rule is None:
            return self.graph.add(op, dtype, args, data)
        values = [self.graph.value(arg) for arg in args]
        if all(value is not None for value in values):
            return self._folded(op, dtype, args, values)
        if op in COMMUTATIVE and values[0] is not None:  # constants stand second
            args, values = (args[1], args[0]), [values[1], values[0]]
        found = rule(self, dtype, args, values)
        if found is not None:
            return found
        if op in COMMUTATIVE and values[1] is None and args[0] > args[1]:
            args = (args[1], args[0])
        return self.graph.add(op, dtype, args, data)

    def _folded(self, op: str, dtype: str, args: tuple[int, ...], values: "Values") -> int:
        """Returns the constant that an operation on constants is; most are met many times."""
        key = op, dtype, args
        if key not in self._constants:
            self._constants[key] = self.graph.constant(evaluate(op, dtype, *values)[()])
        return self._constants[key]

    def constant(self, value: float | int, dtype: str) -> int:
        """Returns the node of a number in a type."""
        return self.graph.constant(np.asarray(value).astype(dtype)[()])

    def same(self, op: str, *args: int) -> int:
        """Returns an operation whose result has the type of its last argument."""
        return self.make(op, self.dtype(args[-1]), args)

    def compare(self, op: str, x: int, y: int) -> int:
        """Returns a comparison, a boolean."""
        return self.make(op, "bool", (x, y))

    def select(self, predicate: int, on_true: int, on_false: int) -> int:
        """Returns one of two nodes by a boolean."""
        return self.same("select", predicate, on_true, on_false)

    def convert(self, x: int, dtype: str) -> int:
        """Returns x in another type."""
        return self.make("convert", dtype, (x,))

    def dtype(self, node: int) -> str:
        """Returns the type of a node."""
        return self.graph.nodes[node].dtype

    def op(self, node: int) -> str:
        """Returns the operation of a node."""
        return self.graph.nodes[node].op

    def args(self, node: int) -> tuple[int, ...]:
        """Returns the arguments of a node."""
        return self.graph.nodes[node].args

    def is_flag(self, node: int) -> bool:
        """Returns whether a node is a boolean as a number, 0 or 1."""
        return self.op(node) == "convert" and self.dtype(self.args(node)[0]) == "bool"

    def substitute(
        self, live: Iterable[int], source: Graph, known: Mapping[int, int], parent: LoopId = OUTSIDE
    ) -> dict[int, int]:
        """Rebuilds live nodes of `source`, in order; `known` says what some of them become.

        Rebuilding in order lets every simplification see its simplified arguments. Loops that the
        nodes belong to are rebuilt too, those that stood outside all others inside `parent`.
        Returns the new id of every live node.
        """
        mapping = dict(known)
        loops: dict[LoopId, LoopId] = {}
        for node_id in live:
            if node_id in mapping:
                continue
            value = source.value(node_id)
            if value is not None:
                mapping[node_id] = self.graph.constant(value)
                continue
            op, dtype, args, data = source.nodes[node_id]
            if op in ("carry", "result"):
                data = (self._loop(source, data[0], loops, parent), data[1])
            mapping[node_id] = self.make(op, dtype, tuple(mapping[arg] for arg in args), data)
        for old, new in loops.items():
            self.graph.loops[new].fill(source.loops[old], mapping)
        return mapping

    def _loop(
        self, source: Graph, loop: LoopId, loops: dict[LoopId, LoopId], parent: LoopId
    ) -> LoopId:
        """Returns what a loop of `source` has become, made on first use."""
        if loop not in loops:
            old = source.loops[loop].parent
            outer = self._loop(source, old, loops, parent) if old in loops else parent
            loops[loop] = self.graph.new_loop(outer)
        return loops[loop]


Values = list[Any]
Rule = Callable[[GraphBuilder, str, tuple[int, ...], Values], int | None]
