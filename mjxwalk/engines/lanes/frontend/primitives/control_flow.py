"""Calls, branches and loops."""

from typing import Any

import numpy as np

from mjxwalk.engines.lanes.frontend.interpreter import (
    Handler,
    Interpreter,
    Jaxpr,
    Keys,
    Known,
    Nodes,
    Params,
    Value,
)
from mjxwalk.engines.lanes.frontend.primitives.elementwise import select_case
from mjxwalk.engines.lanes.frontend.primitives.sizes import INNER_JAXPR, num_equations, work
from mjxwalk.engines.lanes.frontend.primitives.windows import int32, read_row, write_row
from mjxwalk.engines.lanes.ir.graph import LoopId, reachable

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
        if work(branch) < WORTH_SKIPPING:
            with t.inside(guard=guard):
                taken.append(t.call(branch, operands))
        else:
            taken.append(_skippable(t, guard, branch, operands))
    return [
        t.by_words(lambda *values: select_case(t, which, list(values)), *cases)
        for cases in zip(*taken, strict=True)
    ]


def _skippable(t: Interpreter, guard: int, branch: Jaxpr, operands: list[Value]) -> list[Value]:
    """Returns what a branch gives, computed by a loop of one step, or none if no lane is in."""
    nothing = [t.zeros(aval.shape, aval.dtype) for aval in branch.out_avals]
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
    words = _words(operand)
    if not isinstance(words, Nodes) or not isinstance(due, Nodes):
        return operand
    tied = int(due.array)
    ids = [
        t.graph.add("inside", words.dtype, (node, tied)) for node in t.nodes(words).ravel().tolist()
    ]
    tied_words = Nodes(np.array(ids, np.int64).reshape(words.array.shape), words.dtype)
    return Keys(tied_words, operand.type) if isinstance(operand, Keys) else tied_words


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
    """The carried arrays of a loop as one list of scalars; of random keys, their words."""

    def __init__(self, t: Interpreter, values: list[Value]) -> None:
        self.interpreter = t
        self.key_types = [value.type if isinstance(value, Keys) else None for value in values]
        words = list(map(_words, values))
        self.shapes = [value.array.shape for value in words]
        self.dtypes = [value.dtype for value in words]

    def flat(self, values: list[Value]) -> list[int]:
        """Returns the node of every number carried."""
        words = map(_words, values)
        return [node for value in words for node in self.interpreter.nodes(value).ravel().tolist()]

    def arrays(self, ids: list[int]) -> list[Value]:
        """Returns the carried arrays that a flat list of nodes stands for."""
        arrays: list[Value] = []
        start = 0
        kinds = zip(self.shapes, self.dtypes, self.key_types, strict=True)
        for shape, dtype, key_type in kinds:
            size = int(np.prod(shape))
            part = np.array(ids[start : start + size], np.int64).reshape(shape)
            words = self.interpreter.folded(part, dtype)
            arrays.append(words if key_type is None else Keys(words, key_type))
            start += size
        return arrays


def _words(value: Value) -> Known | Nodes:
    return value.words if isinstance(value, Keys) else value


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
    if length * num_equations(p["jaxpr"]) <= MOST_UNROLLED or length <= 1:
        return _unrolled(t, p, consts, carried, rows)
    kept = [aval for aval in p["jaxpr"].out_avals[p["num_carry"] :]]
    outputs = [t.zeros((length, *a.shape), a.dtype) for a in kept]

    def step(values: list[Value]) -> list[Value]:
        count, state = values[0], values[1 : 1 + len(carried)]
        last = int32(length - 1)
        row = t.apply("sub", "int32", last, count) if p["reverse"] else count
        xs = [t.by_words(lambda x: read_row(t, x, row), operand) for operand in rows]
        made = t.call(p["jaxpr"], [*consts, *state, *xs])
        new, ys = made[: len(carried)], made[len(carried) :]
        stored = zip(values[1 + len(carried) :], ys, strict=True)
        written = [
            t.by_words(lambda x, y: write_row(t, x, row, _one_row(t, y)), *pair) for pair in stored
        ]
        return [t.apply("add", "int32", count, int32(1)), *new, *written]

    start: Value = int32(0)
    bound = int32(length)
    results = _loop(
        t, [start, *carried, *outputs], lambda v: t.apply("lt", "bool", v[0], bound), step
    )
    return results[1:]


def _one_row(t: Interpreter, y: Value) -> Value:
    return t.move(lambda x: x[None], y)


def _unrolled(
    t: Interpreter, p: Params, consts: list[Value], carried: list[Value], rows: list[Value]
) -> list[Value]:
    length = p["length"]
    made: list[list[Value]] = []
    for row in range(length - 1, -1, -1) if p["reverse"] else range(length):
        xs = [t.by_words(lambda x, row=row: t.move(lambda y: y[row], x), value) for value in rows]
        outputs = t.call(p["jaxpr"], [*consts, *carried, *xs])
        carried = outputs[: p["num_carry"]]
        made.append(outputs[p["num_carry"] :])
    if p["reverse"]:
        made.reverse()
    if not made:
        avals = p["jaxpr"].out_avals[p["num_carry"] :]
        return [*carried, *(t.zeros((0, *a.shape), a.dtype) for a in avals)]

    def stacked(*column: Value) -> Value:
        return t.move(lambda *xs: np.stack(xs), *column)

    return [*carried, *(t.by_words(stacked, *column) for column in zip(*made, strict=True))]


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
