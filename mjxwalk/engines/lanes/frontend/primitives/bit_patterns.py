"""Primitives about the bits of numbers: counts of bits, neighbours, formats, total order."""

import numpy as np

from mjxwalk.engines.lanes.frontend.interpreter import Handler, Interpreter, Known, Params, Value
from mjxwalk.engines.lanes.frontend.primitives.sorting import ordered


class _Bits:
    """Writes formulas over the bits of numbers of one size, as integers of one sign."""

    def __init__(self, t: Interpreter, dtype: str, signed: bool = True) -> None:
        self.interpreter = t
        self.size = np.dtype(dtype).itemsize * 8
        self.dtype = f"{'' if signed else 'u'}int{self.size}"

    def __call__(self, op: str, x: Value, y: Value | int) -> Value:
        """Returns an operation on two numbers, the second of which may be known."""
        dtype = "bool" if op in ("eq", "ne", "lt", "le") else self.dtype
        return self.interpreter.apply(op, dtype, x, self.number(y) if isinstance(y, int) else y)

    def number(self, number: int) -> Known:
        """Returns the number whose bits these are."""
        kept = number & ((1 << self.size) - 1)
        return Known(np.array(kept, f"uint{self.size}").astype(self.dtype))

    def of(self, x: Value) -> Value:
        """Returns the bits of a number."""
        op = "bitcast" if x.dtype.startswith("float") else "convert"
        return self.interpreter.apply(op, self.dtype, x)

    def where(self, test: Value, x: Value | int, y: Value | int) -> Value:
        """Returns x where a test holds, else y."""
        both = (self.number(z) if isinstance(z, int) else z for z in (x, y))
        return self.interpreter.apply("select", self.dtype, test, *both)


def _ones(t: Interpreter, x: Value) -> Value:
    """Returns how many bits are set: sums of neighbouring groups of 1, 2, 4 ... bits."""
    bits = _Bits(t, x.dtype, signed=False)
    count = bits.of(x)
    width = 1
    while width < bits.size:
        mask = sum(((1 << width) - 1) << at for at in range(0, bits.size, 2 * width))
        count = bits("add", bits("and", count, mask), bits("and", bits("shr", count, width), mask))
        width *= 2
    return count


def _population_count(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    return [t.apply("convert", inputs[0].dtype, _ones(t, inputs[0]))]


def _leading_zeros(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    bits = _Bits(t, inputs[0].dtype, signed=False)
    filled = bits.of(inputs[0])
    width = 1
    while width < bits.size:  # all bits below the highest that is set
        filled = bits("or", filled, bits("shr", filled, width))
        width *= 2
    zeros = t.apply("not", bits.dtype, filled)
    return [t.apply("convert", inputs[0].dtype, _ones(t, zeros))]


def _next_after(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    x, y = inputs
    dtype, bits = x.dtype, _Bits(t, x.dtype)
    zero = Known(np.zeros((), dtype))
    raw, sign = bits.of(x), 1 << (bits.size - 1)
    up = t.apply("eq", "bool", t.apply("lt", "bool", x, y), t.apply("lt", "bool", zero, x))
    near = bits("add", raw, bits.where(up, 1, -1))
    smallest = bits("or", bits("and", bits.of(y), sign), 1)
    near = bits.where(t.apply("eq", "bool", x, zero), smallest, near)
    made = t.apply("bitcast", dtype, near)
    made = t.apply("select", dtype, t.apply("eq", "bool", x, y), y, made)
    for z in (y, x):
        made = t.apply("select", dtype, t.apply("ne", "bool", z, z), z, made)
    return [made]


def _reduce_precision(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
    """Rounds to the nearest number of a smaller format, ties to even; what is too large or too
    small for its exponent becomes infinity or zero."""
    x = inputs[0]
    format_ = np.finfo(x.dtype)
    mantissa, exponent = int(p["mantissa_bits"]), int(p["exponent_bits"])
    bits = _Bits(t, x.dtype, signed=False)
    raw = rounded = bits.of(x)
    lost = format_.nmant - mantissa
    if lost > 0:
        even = bits("and", bits("shr", raw, lost), 1)
        rounded = bits("add", bits("add", raw, (1 << (lost - 1)) - 1), even)
        rounded = bits("and", rounded, -(1 << lost))
    if exponent < format_.nexp:
        size = bits("and", rounded, (1 << (bits.size - 1)) - 1)
        sign = bits("and", raw, 1 << (bits.size - 1))
        bias, largest = (1 << (format_.nexp - 1)) - 1, (1 << (exponent - 1)) - 1
        infinity = ((1 << format_.nexp) - 1) << format_.nmant
        power = bits("shr", size, format_.nmant)
        kept = bits.where(bits("le", power, bias + largest), size, infinity)
        kept = bits.where(bits("le", power, bias - largest), 0, kept)
        rounded = bits("or", kept, sign)
    made = t.apply("bitcast", x.dtype, rounded)
    return [t.apply("select", x.dtype, t.apply("ne", "bool", x, x), x, made)]


def _total_order(op: str) -> Handler:
    """Compares as if NaN of either sign were beyond infinity, and -0 before 0."""

    def handler(t: Interpreter, p: Params, inputs: list[Value]) -> list[Value]:
        return [t.apply(op, "bool", *(ordered(t, x, total=True) for x in inputs))]

    return handler


HANDLERS: dict[str, Handler] = {
    "population_count": _population_count,
    "clz": _leading_zeros,
    "nextafter": _next_after,
    "reduce_precision": _reduce_precision,
    **{f"{op}_to": _total_order(op) for op in ("eq", "lt", "le")},
}
