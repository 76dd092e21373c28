"""How much a jaxpr comes to: what decides whether it is unrolled, or passed over by a loop."""

import math
from typing import Any

from mjxwalk.engines.lanes.frontend.interpreter import Jaxpr
from mjxwalk.engines.lanes.frontend.primitives.data_movement import HANDLERS as MOVERS

INNER_JAXPR = ("jaxpr", "call_jaxpr", "fun_jaxpr")


def work(closed: Jaxpr) -> int:
    """Returns about how many operations a jaxpr comes to, loops counted once."""
    jaxpr = getattr(closed, "jaxpr", closed)
    total = 0
    for equation in jaxpr.eqns:
        inner = [p for p in equation.params.values() if hasattr(p, "eqns") or hasattr(p, "jaxpr")]
        inner += equation.params.get("branches", ())
        total += sum(map(work, inner)) if inner else _size(equation)
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


def num_equations(closed: Jaxpr) -> int:
    """Returns how many equations a jaxpr comes to, those of its calls included."""
    jaxpr = getattr(closed, "jaxpr", closed)
    total = 0
    for equation in jaxpr.eqns:
        inner = [equation.params[name] for name in INNER_JAXPR if name in equation.params]
        inner += equation.params.get("branches", ())
        repeats = equation.params["length"] if equation.primitive.name == "scan" else 1
        total += 1 + repeats * sum(map(num_equations, inner))
    return total
