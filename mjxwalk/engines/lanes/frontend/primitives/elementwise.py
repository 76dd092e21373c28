"""Primitives that compute element by element."""

import numpy as np

from mjxwalk.engines.lanes.frontend.interpreter import Handler, Interpreter, Known, Params, Value
from mjxwalk.engines.lanes.ir.semantics import is_float, is_signed

SAME_NAME = (
    "add sub mul div neg abs max min sqrt rsqrt floor ceil rem sin cos tan asin acos atan atan2 "
    "sinh cosh tanh asinh acosh atanh exp exp2 expm1 log log1p logistic pow cbrt erf erfc erf_inv "
    "and or xor not"
).split()
COMPARISONS = {"lt": ("lt", False), "le": ("le", False), "gt": ("lt", True), "ge": ("le", True),
               "eq": ("eq", False), "ne": ("ne", False)}  # fmt: skip
SHIFTS = {
    "shift_left": "shl",
    "shift_right_logical": "shr",
    "shift_right_arithmetic": "sar",
}


def _plain(op: str) -> Handler:
    def handler(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
        dtype = inputs[0].dtype
        if op == "pow" and inputs[1].dtype != dtype:
            inputs = [inputs[0], t.apply("convert", dtype, inputs[1])]
        return [t.apply(op, dtype, *inputs)]

    return handler


def _comparison(op: str, swapped: bool) -> Handler:
    def handler(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
        return [t.apply(op, "bool", *(reversed(inputs) if swapped else inputs))]

    return handler


def _convert(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return [t.apply("convert", np.dtype(p["new_dtype"]).name, inputs[0])]


def _bitcast(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return [t.apply("bitcast", np.dtype(p["new_dtype"]).name, inputs[0])]


def _square(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return [t.apply("mul", inputs[0].dtype, inputs[0], inputs[0])]


def _integer_pow(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    x, exponent = inputs[0], p["y"]
    one = Known(np.ones(x.array.shape, x.dtype))
    power: Value = one
    for bit in bin(abs(exponent))[2:]:
        power = t.apply("mul", x.dtype, power, power)
        if bit == "1":
            power = t.apply("mul", x.dtype, power, x)
    return [power if exponent >= 0 else t.apply("div", x.dtype, one, power)]


def _sign(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    """-1, 0 or 1; NaN and zeros stay what they are."""
    x = inputs[0]
    zero, one, minus = (Known(np.asarray(n).astype(x.dtype)) for n in (0, 1, -1))
    positive = t.apply("lt", "bool", zero, x)
    sign = t.apply("select", x.dtype, positive, one, x)
    if is_float(x.dtype) or is_signed(x.dtype):
        sign = t.apply("select", x.dtype, t.apply("lt", "bool", x, zero), minus, sign)
    return [sign]


def _is_finite(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    x = inputs[0]
    infinity = Known(np.asarray(np.inf, x.dtype))
    return [t.apply("lt", "bool", t.apply("abs", x.dtype, x), infinity)]


def _round(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    x = inputs[0]
    if int(p["rounding_method"]) == 1:
        return [t.apply("rint", x.dtype, x)]
    half, one, zero = (Known(np.asarray(n, x.dtype)) for n in (0.5, 1.0, 0.0))  # away from zero
    size = t.apply("abs", x.dtype, x)
    whole = t.apply("floor", x.dtype, size)
    up = t.apply("le", "bool", half, t.apply("sub", x.dtype, size, whole))
    size = t.apply("select", x.dtype, up, t.apply("add", x.dtype, whole, one), whole)
    negative = t.apply("lt", "bool", x, zero)
    return [t.apply("select", x.dtype, negative, t.apply("neg", x.dtype, size), size)]


def _clamp(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    low, x, high = inputs
    return [t.apply("min", x.dtype, t.apply("max", x.dtype, x, low), high)]


def _select_n(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    which, *cases = inputs
    return [select_case(t, which, cases)]


def select_case(t: Interpreter, which: Value, cases: list[Value]) -> Value:
    """Returns cases[which], element by element; the last case for anything larger."""
    dtype = cases[0].dtype
    chosen = cases[-1]
    for number in range(len(cases) - 2, -1, -1):
        if which.dtype == "bool":
            chosen = t.apply("select", dtype, which, cases[1], cases[0])
        else:
            bound = Known(np.asarray(number, which.dtype))
            lower = t.apply("le", "bool", which, bound)
            chosen = t.apply("select", dtype, lower, cases[number], chosen)
    return chosen


HANDLERS: dict[str, Handler] = {
    **{name: _plain(name) for name in SAME_NAME},
    "add_any": _plain("add"),
    **{name: _comparison(*meaning) for name, meaning in COMPARISONS.items()},
    **{name: _plain(op) for name, op in SHIFTS.items()},
    "convert_element_type": _convert,
    "bitcast_convert_type": _bitcast,
    "square": _square,
    "integer_pow": _integer_pow,
    "sign": _sign,
    "is_finite": _is_finite,
    "round": _round,
    "clamp": _clamp,
    "select_n": _select_n,
}
