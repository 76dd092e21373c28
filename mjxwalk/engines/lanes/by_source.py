"""Where the operations of a kernel come from: the lines of Python that asked for them."""

import itertools
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Mapping
from pathlib import Path
from typing import Any, Literal, NamedTuple

from mjxwalk.engines.lanes.frontend import tracing
from mjxwalk.engines.lanes.frontend.interpreter import (
    Equation,
    Handler,
    Interpreter,
    Value,
)
from mjxwalk.engines.lanes.ir.builder import GraphBuilder
from mjxwalk.engines.lanes.ir.graph import OUTSIDE, Graph, LoopId
from mjxwalk.engines.lanes.ir.lowering import LoweringBuilder
from mjxwalk.engines.lanes.ir.program import Program, RotatedLoop, Step
from mjxwalk.engines.lanes.ir.scheduling import build_program
from mjxwalk.engines.lanes.ir.simplify import RULES

MOST_TURNS = 1_000  # of a loop that are counted one by one; ours
Unit = Literal["line", "function", "file"]


class Frame(NamedTuple):
    """A line of Python that is not JAX's own."""

    file: str
    function: str
    line: int


Frames = tuple[Frame, ...]  # the innermost first


class Sources(NamedTuple):
    """How many operations a kernel runs for one walker, by the lines that asked for them.

    Attributes:
      of_step: of a step of the loop that does most of the work, or of everything if there is none.
        An inner loop counts as often as it turns, where that is known; else once.
      outside: of what runs once for each walker, before that loop and after it.
    """

    of_step: Mapping[Frames, int]
    outside: Mapping[Frames, int]


class Row(NamedTuple):
    """Operations of a line, function or file.

    Attributes:
      name: of the line, function or file.
      own: operations that stand there.
      whole: the same, and those of what is called there.
    """

    name: str
    own: int
    whole: int


def sources(function: Callable[..., Any], *args: Any) -> Sources:
    """Returns where the operations of a function of one walker come from.

    An operation that several lines ask for counts for the first.

    Args:
      function: as `lanes.vmap` takes it.
      args: of one walker; shapes and types count alone.
    """
    tree, arguments = tracing.own_arguments(args)
    traced = tracing.trace(function, tree, arguments, interpreter=_Tagging)
    program = build_program(traced.graph, traced.outputs, _TellingLowering.tagged)
    return of_program(program)


def of_program(program: Program) -> Sources:
    """Returns where the operations of a program come from; its graph is a `TaggedGraph`."""
    if program.loop is None:
        return Sources(_count(program, program.epilogue), {})
    around = (*program.prologue, *program.epilogue)
    return Sources(_count(program, program.loop.body), _count(program, around))


def rows(counts: Mapping[Frames, int], unit: Unit) -> list[Row]:
    """Returns operations by line, function or file, those of most operations first."""
    own: Counter[str] = Counter()
    whole: Counter[str] = Counter()
    for frames, count in counts.items():
        names = [_name(frame, unit) for frame in frames] or ["nowhere in Python"]
        own[names[0]] += count
        whole.update(dict.fromkeys(names, count))
    found = [Row(name, own[name], whole[name]) for name in whole]
    return sorted(found, key=lambda row: (-row.own, -row.whole, row.name))


def text(counts: Mapping[Frames, int], unit: Unit, most: int) -> str:
    """Returns a table of the lines, functions or files of most operations."""
    lines = [f"{'own':>9}  {'with calls':>10}  {unit}"]
    lines += [f"{row.own:9,}  {row.whole:10,}  {row.name}" for row in rows(counts, unit)[:most]]
    return "\n".join([*lines, f"{sum(counts.values()):9,}  {'':10}  in all"])


def _name(frame: Frame, unit: Unit) -> str:
    parts = Path(frame.file).parts[-3:]
    file = "/".join(parts)
    if unit == "file":
        return file
    return f"{file} {frame.function}" if unit == "function" else f"{file}:{frame.line}"


class TaggedGraph(Graph):
    """A graph that knows which lines were at work when each node was first made.

    Attributes:
      frames: of each node.
      now: of the nodes that are being made.
    """

    def __init__(self) -> None:
        super().__init__()
        self.frames: list[Frames] = []
        self.now: Frames = ()

    def add(self, op: str, dtype: str, args: tuple[int, ...] = (), data: Any = None) -> int:
        found = super().add(op, dtype, args, data)
        if found == len(self.frames):
            self.frames.append(self.now)
        return found


class _Telling(GraphBuilder):
    """A builder that hands on which lines asked for a node to what the node becomes."""

    def substitute(
        self,
        live: Iterable[int],
        source: Graph,
        known: Mapping[int, int],
        parent: LoopId = OUTSIDE,
    ) -> dict[int, int]:
        ours = self.graph
        assert isinstance(source, TaggedGraph) and isinstance(ours, TaggedGraph)
        frames = source.frames

        def telling() -> Generator[int]:
            for node in live:
                ours.now = frames[node]
                yield node

        before = ours.now
        try:
            return super().substitute(telling(), source, known, parent)
        finally:
            ours.now = before


class _TellingLowering(_Telling, LoweringBuilder):
    """The same of a builder that writes out functions."""

    @classmethod
    def tagged(cls, _: Graph) -> "_TellingLowering":
        """Returns one with a graph of its own."""
        return cls(TaggedGraph())


class _Tagging(Interpreter):
    """An interpreter that says of each node which lines asked for it."""

    def __init__(self, handlers: Mapping[str, Handler]) -> None:
        super().__init__(handlers)
        self._tagged = TaggedGraph()
        self.build = _Telling(self._tagged, RULES)

    def _equation(self, equation: Equation, inputs: list[Value]) -> list[Value]:
        caller = self._tagged.now
        self._tagged.now = _frames(equation) + caller
        try:
            return super()._equation(equation, inputs)
        finally:
            self._tagged.now = caller


def _frames(equation: Equation) -> Frames:
    """Returns the lines that asked for an equation, from where its jaxpr was called or traced."""
    from jax._src import source_info_util  # no public way to a traced line; JAX 0.10

    found = source_info_util.user_frames(equation.source_info.traceback)
    ours = itertools.takewhile(lambda each: each.file_name != _TRACED_IN, found)
    return tuple(Frame(each.file_name, each.function_name, each.start_line) for each in ours)


_TRACED_IN = tracing.__file__


def _count(program: Program, steps: Iterable[Step], times: int = 1) -> Counter[Frames]:
    graph = program.graph
    assert isinstance(graph, TaggedGraph)
    found: Counter[Frames] = Counter()
    for step in steps:
        if isinstance(step, RotatedLoop):
            found += _count(program, step.body, times * turns(graph, step))
        else:
            found[graph.frames[step]] += times
    return found


def turns(graph: Graph, loop: RotatedLoop) -> int:
    """Returns how often a loop turns if it counts from one number to another, else 1."""
    test = graph.nodes[loop.next_test]
    if test.op not in ("lt", "le"):
        return 1
    after, bound = test.args
    last = graph.value(bound)
    for place, then in loop.following.items():
        first = graph.value(loop.initial[place])
        node = graph.nodes[then]
        if then != after or first is None or last is None or node.op != "add":
            continue
        step = graph.value(node.args[1])
        if node.args[0] == loop.carries[place] and step is not None and step > 0:
            reach = int(last) - int(first) + (test.op == "le")
            return min(max(-(-reach // int(step)), 1), MOST_TURNS)
    return 1
