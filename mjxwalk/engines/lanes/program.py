"""From a graph to a program: what runs once for a walker, what every step runs, and in which order.

The loop that does most of the work is the program's own: its lanes are refilled when their walker
ends. What depends on no step of it is the prologue, what depends on its results the epilogue.
"""

import dataclasses
from collections.abc import Callable, Iterable, Sequence

from mjxwalk.engines.lanes.builder import Builder
from mjxwalk.engines.lanes.expand import Expander
from mjxwalk.engines.lanes.graph import OUTSIDE, Graph, carried, reachable, regions
from mjxwalk.engines.lanes.ordering import ordered


@dataclasses.dataclass(frozen=True, kw_only=True)
class Turns:
    """A loop as machine code has it: a test before the first step and one after every step.

    Attributes:
      initial, following, carries, results: nodes by place; `carries` what the body reads, `results`
        what the code after the loop reads.
      first: whether to take a first step, computed from `initial`.
      again: whether to take another, computed from `following`.
      body: what a step computes, in order.
      needs: nodes from outside that body, tests and start need.
    """

    number: int
    carries: dict[int, int]
    initial: dict[int, int]
    following: dict[int, int]
    first: int
    again: int
    body: "tuple[Step, ...]"
    needs: frozenset[int]


Step = int | Turns  # a node to compute, or a loop to run


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
    loop: Turns | None
    epilogue: tuple[Step, ...]


def program(
    source: Graph, outputs: Sequence[int], make: Callable[[Graph], Builder] = Expander
) -> Program:
    """Returns the program that computes `outputs`, from a graph as traced.

    Args:
      make: of the builder of the program's graph; it says what is written out and what is not.
    """
    build = make(Graph())
    mapping = build.substitute(reachable(source, outputs), source, {})
    graph = build.graph
    graph.tables = source.tables
    outputs = [mapping[node] for node in outputs]
    tests = {number: _tests(build, number) for number in range(len(graph.loops))}
    return _Scheduler(graph, outputs, tests).program()


def _tests(build: Builder, number: int) -> tuple[int, int]:
    """Returns a loop's test, computed from its first values and from those after a step."""
    graph, loop = build.graph, build.graph.loops[number]
    carries = {graph.add("carry", graph.nodes[node].dtype, (), (number, place)): place
               for place, node in loop.initial.items()}  # fmt: skip
    tests: list[int] = []
    for values, parent in ((loop.initial, loop.parent), (loop.following, number)):
        known = {carry: values[place] for carry, place in carries.items()}
        older = [n for n in reachable(graph, [loop.condition], known) if n not in known]
        moved = _dependent(graph, older, known)
        fixed = {n: n for n in older if n not in moved} | known
        mapping = build.substitute(older, graph, fixed, parent)
        tests.append(mapping[loop.condition])
    return tests[0], tests[1]


def _dependent(graph: Graph, nodes: Iterable[int], roots: Iterable[int]) -> set[int]:
    """Returns which of the nodes, in order, depend on any of the roots."""
    found = set(roots)
    for node_id in nodes:
        node = graph.nodes[node_id]
        needs = node.args
        if node.op == "result":
            loop, place = carried(node)
            inner = graph.loops[loop]
            needs = (*needs, inner.initial[place], inner.following[place], inner.condition)
        if any(arg in found for arg in needs):
            found.add(node_id)
    return found


class _Scheduler:
    """Orders the nodes of each region, a value as late as its first use allows."""

    def __init__(
        self, graph: Graph, outputs: Sequence[int], tests: dict[int, tuple[int, int]]
    ) -> None:
        self.graph = graph
        self.outputs = tuple(outputs)
        self.tests = tests
        roots = [*outputs, *(test for pair in tests.values() for test in pair)]
        self.live = reachable(graph, roots)
        self.region = regions(graph, self.live)
        self.places: dict[int, dict[int, int]] = {n: {} for n in range(len(graph.loops))}
        for node_id in self.live:
            node = graph.nodes[node_id]
            if node.op == "carry":
                number, place = carried(node)
                self.places[number][place] = node_id
            elif node.op == "result":  # a result whose carry nobody reads still has a place
                number, place = carried(node)
                carry = graph.add("carry", node.dtype, (), node.data)
                self.places[number][place] = carry
                self.region[carry] = number
        self.turns: dict[int, Turns] = {}
        self.pressure: dict[int, int] = {}

    def program(self) -> Program:
        graph = self.graph
        outermost = [n for n, loop in enumerate(graph.loops)
                     if loop.parent == OUTSIDE and self.places[n]]  # fmt: skip
        if not outermost:
            steps = self.order(self.outputs, OUTSIDE, frozenset())
            return Program(
                graph=graph, outputs=self.outputs, prologue=(), loop=None, epilogue=steps
            )
        main = max(outermost, key=lambda n: _size(self.loop(n).body))
        loop = self.loop(main)
        results = {n for n in self.live if self.graph.nodes[n].op == "result"
                   and carried(self.graph.nodes[n])[0] == main}  # fmt: skip
        after = _dependent(graph, [n for n in self.live if self.region[n] == OUTSIDE], results)
        roots = [*loop.initial.values(), loop.first, *sorted(loop.needs)]
        roots += [n for n in self.outputs if n not in after]
        roots += [a for n in sorted(after) for a in self.inputs_of(n) if a not in after]
        prologue = self.order(roots, OUTSIDE, frozenset())
        done = frozenset(n for n in prologue if isinstance(n, int)) | results
        epilogue = self.order(self.outputs, OUTSIDE, done)
        return Program(graph=graph, outputs=self.outputs, prologue=prologue, loop=loop,
                       epilogue=epilogue)  # fmt: skip

    def loop(self, number: int) -> Turns:
        """Returns a loop with its body in order."""
        if number in self.turns:
            return self.turns[number]
        loop, places = self.graph.loops[number], self.places[number]
        initial = {place: loop.initial[place] for place in sorted(places)}
        following = {place: loop.following[place] for place in sorted(places)}
        first, again = self.tests[number]
        body = self.order([*following.values(), again], number, frozenset())
        used = {a for step in body for a in self.needs_of(step)}
        used |= {*following.values(), again, *initial.values(), first}
        needs = frozenset(n for n in used if not self.inside(n, number))
        self.turns[number] = Turns(
            number=number, carries=places, initial=initial, following=following, first=first,
            again=again, body=body, needs=needs,
        )  # fmt: skip
        return self.turns[number]

    def inside(self, node: int, number: int) -> bool:
        """Returns whether a node is computed within a loop."""
        region = self.region[node]
        while region not in (OUTSIDE, number):
            region = self.graph.loops[region].parent
        return region == number

    def inputs_of(self, node_id: int) -> tuple[int, ...]:
        """Returns what a node waits for: its arguments, or all that its loop needs."""
        node = self.graph.nodes[node_id]
        if node.op == "result":
            return tuple(sorted(self.loop(carried(node)[0]).needs))
        return node.args

    def _pressure(self) -> dict[int, int]:
        """Returns how many values are alive at once while a node's arguments are computed.

        Sethi and Ullman's number: the argument that needs most comes first.
        """
        if not self.pressure:
            for node_id, node in enumerate(self.graph.nodes):
                ranked = sorted((self.pressure[arg] for arg in node.args), reverse=True)
                most = (number + place for place, number in enumerate(ranked))
                self.pressure[node_id] = max(most, default=1)
        return self.pressure

    def needs_of(self, step: Step) -> Iterable[int]:
        return step.needs if isinstance(step, Turns) else self.graph.nodes[step].args

    def order(self, roots: Sequence[int], region: int, done: frozenset[int]) -> tuple[Step, ...]:
        """Returns the steps of a region that the roots need, each after what it waits for."""
        steps: list[Step] = []
        seen = set(done)
        ran: set[int] = set()
        pressure = self._pressure()
        pending = [(root, False) for root in reversed(roots)]
        while pending:
            node_id, ready = pending.pop()
            node = self.graph.nodes[node_id]
            if node_id in seen or self.region[node_id] != region or node.op in ("const", "carry"):
                continue
            if not ready:
                pending.append((node_id, True))
                needs = sorted(self.inputs_of(node_id), key=pressure.__getitem__)
                pending += [(need, False) for need in needs]
                continue
            seen.add(node_id)
            if node.op != "result":
                steps.append(node_id)
            elif carried(node)[0] not in ran:
                ran.add(carried(node)[0])
                steps.append(self.loop(carried(node)[0]))
        return self._scheduled(steps)

    def _scheduled(self, steps: list[Step]) -> tuple[Step, ...]:
        """Returns steps rearranged for the CPU; those with loops among them stay as they are."""
        plain = [step for step in steps if isinstance(step, int)]
        if len(plain) < len(steps):
            return tuple(steps)
        nodes, own = self.graph.nodes, set(plain)
        needs = {n: [a for a in dict.fromkeys(nodes[n].args) if a in own] for n in plain}
        return tuple(ordered(plain, needs, {n: nodes[n].op for n in plain}))


def _size(steps: Iterable[Step]) -> int:
    return sum(_size(step.body) if isinstance(step, Turns) else 1 for step in steps)


def operations(program: Program) -> int:
    """Returns how many scalar operations a step of the program's loop takes."""
    return _size(program.loop.body if program.loop else program.epilogue)
