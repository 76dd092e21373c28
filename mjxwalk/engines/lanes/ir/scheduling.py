"""From a graph to a program: the regions of the graph in order, and its loops rotated."""

from collections.abc import Callable, Iterable, Sequence

from mjxwalk.engines.lanes.ir.builder import GraphBuilder
from mjxwalk.engines.lanes.ir.graph import OUTSIDE, Graph, LoopId, carried, reachable, regions
from mjxwalk.engines.lanes.ir.list_scheduling import ordered
from mjxwalk.engines.lanes.ir.lowering import LoweringBuilder
from mjxwalk.engines.lanes.ir.program import Program, RotatedLoop, Step, needs_of, size


def build_program(
    source: Graph, outputs: Sequence[int], make: Callable[[Graph], GraphBuilder] = LoweringBuilder
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
    tests: dict[LoopId, tuple[int, int]] = {}
    while len(tests) < len(graph.loops):  # a test that has a loop within it makes another one
        loop = LoopId(len(tests))
        tests[loop] = _tests(build, loop)
    return _Scheduler(graph, outputs, tests).program()


def _tests(build: GraphBuilder, number: LoopId) -> tuple[int, int]:
    """Returns a loop's test, computed from its first values and from those after a step."""
    graph, loop = build.graph, build.graph.loops[number]
    carries = _carries(graph, number)
    # A step of a loop around this one depends on this loop; within that step its carries are fixed.
    around: set[int] = set()
    outer = loop.parent
    while outer != OUTSIDE:
        around.update(_carries(graph, outer))
        outer = graph.loops[outer].parent
    tests: list[int] = []
    for values, parent in ((loop.initial, loop.parent), (loop.following, number)):
        known = {carry: values[place] for carry, place in carries.items()}
        older = [
            n for n in reachable(graph, [loop.condition], around | set(known)) if n not in known
        ]
        moved = _moved(graph, older, known)
        fixed = {n: n for n in older if n not in moved} | known
        mapping = build.substitute(older, graph, fixed, parent)
        tests.append(mapping[loop.condition])
    return tests[0], tests[1]


def _carries(graph: Graph, number: LoopId) -> dict[int, int]:
    """Returns the place of each carry of a loop."""
    initial = graph.loops[number].initial
    return {graph.add("carry", graph.dtype(node), (), (number, place)): place
            for place, node in initial.items()}  # fmt: skip


def _moved(graph: Graph, nodes: Sequence[int], roots: Iterable[int]) -> set[int]:
    """Returns which of the nodes, in order, change with the roots: a loop does as a whole."""
    roots = set(roots)
    while True:
        moved = _dependent(graph, nodes, roots)
        loops = {carried(graph.nodes[n])[0] for n in moved if graph.nodes[n].op == "result"}
        carries = {n for n in nodes if graph.nodes[n].op == "carry"
                   and carried(graph.nodes[n])[0] in loops}  # fmt: skip
        if carries <= roots:
            return moved
        roots |= carries


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
        self, graph: Graph, outputs: Sequence[int], tests: dict[LoopId, tuple[int, int]]
    ) -> None:
        self.graph = graph
        self.outputs = tuple(outputs)
        self.tests = tests
        roots = [*outputs, *(test for pair in tests.values() for test in pair)]
        self.live = reachable(graph, roots)
        self.region = regions(graph, self.live)
        self.places: dict[LoopId, dict[int, int]] = {n: {} for n in graph.loops}
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
        self.rotated: dict[LoopId, RotatedLoop] = {}
        self.pressure: dict[int, int] = {}

    def program(self) -> Program:
        graph = self.graph
        outermost = [n for n, loop in graph.loops.items()
                     if loop.parent == OUTSIDE and self.places[n]]  # fmt: skip
        if not outermost:
            steps = self.order(self.outputs, OUTSIDE, frozenset())
            return Program(
                graph=graph, outputs=self.outputs, prologue=(), loop=None, epilogue=steps
            )
        main = max(outermost, key=lambda n: size(graph, self.loop(n).body))
        loop = self.loop(main)
        results = {n for n in self.live if self.graph.nodes[n].op == "result"
                   and carried(self.graph.nodes[n])[0] == main}  # fmt: skip
        after = _dependent(graph, [n for n in self.live if self.region[n] == OUTSIDE], results)
        roots = [*loop.initial.values(), loop.first_test, *sorted(loop.external_inputs)]
        roots += [n for n in self.outputs if n not in after]
        roots += [a for n in sorted(after) for a in self.inputs_of(n) if a not in after]
        prologue = self.order(roots, OUTSIDE, frozenset())
        done = frozenset(n for n in prologue if isinstance(n, int)) | results
        epilogue = self.order(self.outputs, OUTSIDE, done)
        return Program(graph=graph, outputs=self.outputs, prologue=prologue, loop=loop,
                       epilogue=epilogue)  # fmt: skip

    def loop(self, number: LoopId) -> RotatedLoop:
        """Returns a loop with its body in order."""
        if number in self.rotated:
            return self.rotated[number]
        loop, places = self.graph.loops[number], self.places[number]
        initial = {place: loop.initial[place] for place in sorted(places)}
        following = {place: loop.following[place] for place in sorted(places)}
        first, again = self.tests[number]
        body = self.order([*following.values(), again], number, frozenset())
        used = {a for step in body for a in needs_of(self.graph, step)}
        used |= {*following.values(), again, *initial.values(), first}
        external = frozenset(n for n in used if not self.inside(n, number))
        self.rotated[number] = RotatedLoop(
            id=number, carries=places, initial=initial, following=following, first_test=first,
            next_test=again, body=body, external_inputs=external,
        )  # fmt: skip
        return self.rotated[number]

    def inside(self, node: int, number: LoopId) -> bool:
        """Returns whether a node is computed within a loop."""
        region = self.region[node]
        while region not in (OUTSIDE, number):
            region = self.graph.loops[region].parent
        return region == number

    def inputs_of(self, node_id: int) -> tuple[int, ...]:
        """Returns what a node waits for: its arguments, or all that its loop needs."""
        node = self.graph.nodes[node_id]
        if node.op == "result":
            return tuple(sorted(self.loop(carried(node)[0]).external_inputs))
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

    def order(self, roots: Sequence[int], region: LoopId, done: frozenset[int]) -> tuple[Step, ...]:
        """Returns the steps of a region that the roots need, each after what it waits for."""
        steps: list[Step] = []
        seen = set(done)
        ran: set[LoopId] = set()
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
