"""Every stage of a compilation as text, for reading.

`python -m mjxwalk.engines.lanes.explain` prints the example of docs/lanes.md; with `--by-source`,
the lines that its operations come from.
"""

import re
import sys
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from mjxwalk.engines.lanes import by_source
from mjxwalk.engines.lanes.backend import machine_code
from mjxwalk.engines.lanes.backend.kernel import emit_kernel
from mjxwalk.engines.lanes.frontend.tracing import own_arguments, trace
from mjxwalk.engines.lanes.ir.graph import Graph
from mjxwalk.engines.lanes.ir.program import Program, RotatedLoop, Step
from mjxwalk.engines.lanes.ir.scheduling import build_program


class Explanation(NamedTuple):
    """A function stage by stage; of IR and assembly only the block that does the work."""

    jaxpr: str
    graph: str
    ir: str
    assembly: str


def explain(function: Callable[..., Any], *args: Any, width: int | None = None) -> Explanation:
    """Returns the stages of compiling a function of one walker; args are one walker's own."""
    tree, arguments = own_arguments(args)
    traced = trace(function, tree, arguments)
    whole = build_program(traced.graph, traced.outputs)
    chosen = machine_code.host(width)
    text = emit_kernel(whole, arguments, traced.results, chosen).text
    code = machine_code.assembly(text, chosen)
    return Explanation(
        jaxpr=str(jax.make_jaxpr(function)(*args)),
        graph=_listing(whole),
        ir=_longest(text, r"\n(?=[\w.]+:)"),
        assembly=_longest(code, r"\n(?=\.LBB)"),
    )


def _listing(whole: Program) -> str:
    lines = ["prologue:", *_lines(whole.graph, whole.prologue)]
    if whole.loop is not None:
        lines += ["loop:", *_lines(whole.graph, whole.loop.body)]
        then = whole.loop.following
        lines += [f"  next c{place} = {_name(whole.graph, then[place])}" for place in then]
        lines += [f"  again = {_name(whole.graph, whole.loop.next_test)}"]
    return "\n".join([*lines, "epilogue:", *_lines(whole.graph, whole.epilogue)])


def _lines(graph: Graph, steps: Iterable[Step]) -> list[str]:
    lines: list[str] = []
    for step in steps:
        if isinstance(step, RotatedLoop):
            lines += [f"  loop {step.id}:", *("  " + line for line in _lines(graph, step.body))]
        elif graph.nodes[step].op != "input":
            args = " ".join(_name(graph, arg) for arg in graph.nodes[step].args)
            lines.append(f"  {_name(graph, step)} = {graph.nodes[step].op} {args}")
    return lines


def _name(graph: Graph, node_id: int) -> str:
    node = graph.nodes[node_id]
    value = graph.value(node_id)
    if value is not None:
        return f"{value:g}" if node.dtype.startswith("float") else str(value)
    if node.op == "input":
        return f"in{node.data[0]}[{node.data[1]}]"
    if node.op in ("carry", "result"):
        return f"{node.op[0]}{node.data[1]}"
    return f"%{node_id}"


def _longest(text: str, boundary: str) -> str:
    return max(re.split(boundary, text), key=len)


MOST_ROWS = 25  # of a table of operations
GEARING = np.eye(2, dtype=np.float32)  # a constant for the compiler to fold away


def swing(angle: Any, torque: Any) -> Any:
    """Returns the angle of a pendulum after a second, pushed by a torque."""

    def step(state: Any) -> Any:
        time, angle, speed = state
        speed = speed + 0.01 * (torque / 2.0 - 9.81 * jnp.sin(angle) * GEARING[0, 0])
        return time + 0.01, angle + 0.01 * speed, speed

    return jax.lax.while_loop(lambda state: state[0] < 1.0, step, (0.0, angle, 0.0))[1]


if __name__ == "__main__":
    if sys.argv[1:] == ["--by-source"]:
        found = by_source.sources(swing, np.float32(0.1), np.float32(0.0))
        sys.exit(print(by_source.text(found.of_step, "line", MOST_ROWS)))
    for name, text in explain(swing, np.float32(0.1), np.float32(0.0))._asdict().items():
        print(f"--- {name}\n{text}\n")
