"""Calls, branches and loops."""

import math
from typing import Any

import numpy as np

from mjxwalk.engines.lanes.frontend.interpreter import (
    Handler,
    Interpreter,
    Jaxpr,
    Known,
    Nodes,
    Params,
    Value,
)
from mjxwalk.engines.lanes.frontend.primitives.data_movement import HANDLERS as MOVERS
from mjxwalk.engines.lanes.frontend.primitives.elementwise import select_case
from mjxwalk.engines.lanes.frontend.primitives.windows import int32, read_row, write_row
from mjxwalk.engines.lanes.ir.graph import LoopId, reachable

INNER_JAXPR = ("jaxpr", "call_jaxpr", "fun_jaxpr")
MOST_UNROLLED = 2_000  # equations after unrolling a scan; a longer one becomes a loop
WORTH_SKIPPING = 500  # operations of a branch that lanes enter only if one of them takes it; ours


def _call(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return t.call(next(p[name] for name in INNER_JAXPR if name in p), inputs)


def _cond(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    which, *operands = inputs
    branches = p["branches"]
    if isinstance(which, Known):
        return t.call(branches[int(np.clip(which.array, 0, len(branches) - 1))], operands)
    taken: list[list[Value]] = []
    for number, branch in enumerate(branches):
        guard = _taken(t, which, number, len(branches))
        if _work(branch) < WORTH_SKIPPING:
            with t.inside(guard=guard):
                taken.append(t.call(branch, operands))
        else:
            taken.append(_skippable(t, guard, branch, operands))
    return [select_case(t, which, list(cases)) for cases in zip(*taken, strict=True)]


def _skippable(t: Interpreter, guard: int, branch: Jaxpr, operands: list[Value]) -> list[Value]:
    """Returns what a branch gives, computed by a loop of one step, or none if no lane is in."""
    nothing = [Known(np.zeros(aval.shape, aval.dtype)) for aval in branch.out_avals]
    due = Nodes(np.array(guard, np.int64), "bool")
    done = Known(np.zeros((), np.bool_))

    def step(values: list[Value]) -> list[Value]:
        inside = [_inside(t, operand, values[0]) for operand in operands]
        return [done, *t.call(branch, inside)]

    return _loop(t, [due, *nothing], lambda values: values[0], step)[1:]


def _inside(t: Interpreter, operand: Value, due: Value) -> Value:
    """Returns an operand of a branch as something that its loop computes.

    Else all that the branch makes of it would be seen to be the same in every turn of the loop, and
    be computed before it.
    """
    if not isinstance(operand, Nodes) or not isinstance(due, Nodes):
        return operand
    tied = int(due.array)
    ids = [
        t.graph.add("inside", operand.dtype, (node, tied))
        for node in t.nodes(operand).ravel().tolist()
    ]
    return Nodes(np.array(ids, np.int64).reshape(operand.array.shape), operand.dtype)


def _work(closed: Jaxpr) -> int:
    """Returns about how many operations a jaxpr comes to, loops counted once."""
    jaxpr = getattr(closed, "jaxpr", closed)
    total = 0
    for equation in jaxpr.eqns:
        inner = [p for p in equation.params.values() if hasattr(p, "eqns") or hasattr(p, "jaxpr")]
        inner += equation.params.get("branches", ())
        total += sum(map(_work, inner)) if inner else _size(equation)
    return total


def _size(equation: Any) -> int:
    """Returns about how many operations an equation without equations in it comes to."""
    if equation.primitive.name not in MOVERS:
        made = sum(variable.aval.size for variable in equation.outvars)
        if equation.primitive.name == "dot_general":
            (contracted, _), _ = equation.params["dimension_numbers"]
            shape = equation.invars[0].aval.shape
            made *= math.prod(shape[axis] for axis in contracted)
        return made
    return 0


def _taken(t: Interpreter, which: Value, number: int, count: int) -> int:
    """Returns the node that says whether a walker takes this branch, an index clamped to them."""
    bound = Known(np.asarray(number).astype(which.dtype))
    if which.dtype == "bool":
        test = t.apply("eq", "bool", which, bound)
    elif number == 0:
        test = t.apply("le", "bool", which, bound)
    elif number == count - 1:
        test = t.apply("le", "bool", bound, which)
    else:
        test = t.apply("eq", "bool", which, bound)
    return int(t.nodes(test))


class _Carried:
    """The carried arrays of a loop as one list of scalars."""

    def __init__(self, t: Interpreter, values: list[Value]) -> None:
        self.interpreter = t
        self.shapes = [value.array.shape for value in values]
        self.dtypes = [value.dtype for value in values]

    def flat(self, values: list[Value]) -> list[int]:
        """Returns the node of every number carried."""
        return [node for value in values for node in self.interpreter.nodes(value).ravel().tolist()]

    def arrays(self, ids: list[int]) -> list[Value]:
        """Returns the carried arrays that a flat list of nodes stands for."""
        arrays: list[Value] = []
        start = 0
        for shape, dtype in zip(self.shapes, self.dtypes, strict=True):
            size = int(np.prod(shape))
            part = np.array(ids[start : start + size], np.int64).reshape(shape)
            arrays.append(self.interpreter.folded(part, dtype))
            start += size
        return arrays


def _loop(t: Interpreter, carried: list[Value], test: Any, step: Any) -> list[Value]:
    """Returns what `carried` becomes by `step`, while `test` of the carried arrays holds."""
    shape = _Carried(t, carried)
    graph, build = t.graph, t.build
    initial = shape.flat(carried)
    number = graph.new_loop(t.region)
    carries = [
        graph.add("carry", graph.nodes[first].dtype, (), (number, place))
        for place, first in enumerate(initial)
    ]
    guard = t.guard
    with t.inside(region=number):
        condition = int(t.nodes(test(shape.arrays(carries))))
        following = shape.flat(step(shape.arrays(carries)))
    if guard is not None:
        condition = build.same("and", condition, guard)
    following, condition, known = _settle(t, number, carries, initial, following, condition)
    loop = graph.loops[number]
    results: list[int] = []
    for place, (first, then, carry) in enumerate(zip(initial, following, carries, strict=True)):
        if known[carry] != carry:
            results.append(first)
            continue
        loop.initial[place], loop.following[place] = first, then
        results.append(graph.add("result", graph.nodes[first].dtype, (), (number, place)))
    loop.condition = condition
    return shape.arrays(results)


def _settle(
    t: Interpreter,
    loop: LoopId,
    carries: list[int],
    initial: list[int],
    following: list[int],
    condition: int,
) -> tuple[list[int], int, dict[int, int]]:
    """Replaces carries that never change by what they start as, until all that are left change.

    Loops inside this one, whose number is given, are rebuilt inside it. Returns the new values
    after a step, the new test, and what each carry became.
    """
    known = dict(zip(carries, carries, strict=True))
    while True:
        constant = [
            (carry, first)
            for carry, first, then in zip(carries, initial, following, strict=True)
            if known[carry] == carry and then in (carry, first)
        ]
        if not constant:
            return following, condition, known
        known.update(constant)
        roots = [*following, condition]
        older = range(min(carries))  # nodes older than the loop do not depend on its carries
        fixed = {node: node for node in older} | known
        live = [n for n in reachable(t.graph, roots, fixed) if n not in fixed]
        mapping = t.build.substitute(live, t.graph, fixed, parent=loop)
        following = [mapping.get(node, node) for node in following]
        condition = mapping.get(condition, condition)


def _while(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    ends = p["cond_nconsts"], p["cond_nconsts"] + p["body_nconsts"]
    for_test, for_step, carried = inputs[: ends[0]], inputs[ends[0] : ends[1]], inputs[ends[1] :]
    return _loop(
        t,
        carried,
        lambda values: t.call(p["cond_jaxpr"], [*for_test, *values])[0],
        lambda values: t.call(p["body_jaxpr"], [*for_step, *values]),
    )


def _scan(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    consts, rest = inputs[: p["num_consts"]], inputs[p["num_consts"] :]
    carried, rows = rest[: p["num_carry"]], rest[p["num_carry"] :]
    length = p["length"]
    if length * _equations(p["jaxpr"]) <= MOST_UNROLLED or length <= 1:
        return _unrolled(t, p, consts, carried, rows)
    kept = [aval for aval in p["jaxpr"].out_avals[p["num_carry"] :]]
    outputs: list[Value] = [Known(np.zeros((length, *a.shape), a.dtype)) for a in kept]

    def step(values: list[Value]) -> list[Value]:
        count, state = values[0], values[1 : 1 + len(carried)]
        last = int32(length - 1)
        row = t.apply("sub", "int32", last, count) if p["reverse"] else count
        xs = [read_row(t, operand, row) for operand in rows]
        made = t.call(p["jaxpr"], [*consts, *state, *xs])
        new, ys = made[: len(carried)], made[len(carried) :]
        stored = zip(values[1 + len(carried) :], ys, strict=True)
        written = [write_row(t, array, row, _one_row(t, y)) for array, y in stored]
        return [t.apply("add", "int32", count, int32(1)), *new, *written]

    start: Value = int32(0)
    bound = int32(length)
    results = _loop(
        t, [start, *carried, *outputs], lambda v: t.apply("lt", "bool", v[0], bound), step
    )
    return results[1:]


def _one_row(t: Interpreter, y: Value) -> Value:
    return t.move(lambda x: x[None], y)


def _equations(closed: Jaxpr) -> int:
    """Returns how many equations a jaxpr comes to, those of its calls included."""
    jaxpr = getattr(closed, "jaxpr", closed)
    total = 0
    for equation in jaxpr.eqns:
        inner = [equation.params[name] for name in INNER_JAXPR if name in equation.params]
        inner += equation.params.get("branches", ())
        repeats = equation.params["length"] if equation.primitive.name == "scan" else 1
        total += 1 + repeats * sum(map(_equations, inner))
    return total


def _unrolled(
    t: Interpreter, p: Params, consts: list[Value], carried: list[Value], rows: list[Value]
) -> list[Value]:
    length = p["length"]
    made: list[list[Value]] = []
    for row in range(length - 1, -1, -1) if p["reverse"] else range(length):
        xs = [t.move(lambda x, row=row: x[row], operand) for operand in rows]
        outputs = t.call(p["jaxpr"], [*consts, *carried, *xs])
        carried = outputs[: p["num_carry"]]
        made.append(outputs[p["num_carry"] :])
    if p["reverse"]:
        made.reverse()
    if not made:
        avals = p["jaxpr"].out_avals[p["num_carry"] :]
        return [*carried, *(Known(np.zeros((0, *a.shape), a.dtype)) for a in avals)]
    columns = zip(*made, strict=True)
    return [*carried, *(t.move(lambda *xs: np.stack(xs), *column) for column in columns)]


CALLS = (
    "jit pjit closed_call core_call custom_jvp_call custom_vjp_call custom_vjp_call_jaxpr remat "
    "remat2 checkpoint custom_lin core_closed_call"
).split()

HANDLERS: dict[str, Handler] = {
    **dict.fromkeys(CALLS, _call),
    "cond": _cond,
    "while": _while,
    "scan": _scan,
}
