"""Functions that no CPU has an instruction for, as graphs of operations that it has.

Polynomials are those of Cephes (Moshier, https://www.netlib.org/cephes/, single precision), good
to about two units in the last place. Since they are made of nodes, sin and cos of one angle share
their range reduction without being told to. `pow`, and anything asked for in float64, goes through
float64 series.

sin, cos and tan reduce their argument exactly enough up to 1e5; beyond, the error grows with the
argument and the result stays within [-1, 1].
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from mjxwalk.engines.lanes.simplify import Builder

Expansion = Callable[[Builder, int], int]

HALF_PI_FEW_BITS = (1.5703125, 4.84466552734375e-4, -6.39757837817001e-7)  # 8, 8 and 24 bits
SIN = (-1.6666654611e-1, 8.3321608736e-3, -1.9515295891e-4)
COS = (4.166664568298827e-2, -1.388731625493765e-3, 2.443315711809948e-5)
EXP = (0.5, 1.6666665459e-1, 4.1665795894e-2, 8.3334519073e-3, 1.3981999507e-3, 1.9875691500e-4)
LOG = (3.3333331174e-1, -2.4999993993e-1, 2.0000714765e-1, -1.6668057665e-1, 1.4249322787e-1,
       -1.2420140846e-1, 1.1676998740e-1, -1.1514610310e-1, 7.0376836292e-2)  # fmt: skip
TANH = (-3.33332819422e-1, 1.33314422036e-1, -5.37397155531e-2, 2.06390887954e-2, -5.70498872745e-3)
ATAN = (-3.33329491539e-1, 1.99777106478e-1, -1.38776856032e-1, 8.05374449538e-2)
ASIN = (1.6666752422e-1, 7.4953002686e-2, 4.5470025998e-2, 2.4181311049e-2, 4.2163199048e-2)
ROUND_BY_ADDING = 12582912.0  # 1.5 * 2**23: adding it leaves the nearest integer in the low bits


class Formula:
    """Writes formulas over one type: numbers become constants as they are met."""

    def __init__(self, build: Builder, dtype: str) -> None:
        self.build = build
        self.dtype = dtype

    def __call__(self, op: str, *args: int | float) -> int:
        """Returns an operation on nodes (int) and numbers (float)."""
        ids = tuple(self.number(a) if isinstance(a, float) else a for a in args)
        dtype = "bool" if op in ("lt", "le", "eq", "ne") else self.dtype
        return self.build.make(op, dtype, ids)

    def number(self, value: float) -> int:
        """Returns the constant node of a number."""
        return self.build.constant(value, self.dtype)

    def polynomial(self, x: int, coefficients: Sequence[float]) -> int:
        """Returns c0 + c1 x + c2 x^2 + ... by Horner's rule."""
        total = self.number(coefficients[-1])
        for coefficient in reversed(coefficients[:-1]):
            total = self("add", self("mul", total, x), coefficient)
        return total

    @property
    def bits(self) -> "Formula":
        """Formulas over the integers of the same size."""
        return Formula(self.build, "int32" if self.dtype == "float32" else "int64")

    def integer(self, value: int) -> int:
        """Returns the constant node of an integer."""
        return self.build.constant(value, self.dtype)

    def cast(self, x: int) -> int:
        """Returns the bits of x as this formula's type."""
        return self.build.make("bitcast", self.dtype, (x,))


def _sine(x: int, build: Builder, quarter: int) -> int:
    """Returns sin(x + quarter * pi / 2)."""
    f = Formula(build, "float32")
    bits = f.bits
    shifted = f("add", f("mul", x, 2 / math.pi), ROUND_BY_ADDING)
    turns = f("sub", shifted, ROUND_BY_ADDING)
    r = x
    for part in HALF_PI_FEW_BITS:
        r = f("sub", r, f("mul", turns, part))
    r = f("min", f("max", r, -0.79), 0.79)  # what reduction lost must not leave [-1, 1]
    square = f("mul", r, r)
    sine = f("add", f("mul", f("mul", f.polynomial(square, SIN), square), r), r)
    tail = f("mul", f("mul", f.polynomial(square, COS), square), square)
    cosine = f("add", f("add", tail, f("mul", square, -0.5)), 1.0)
    quadrant = bits("add", bits.cast(shifted), bits.integer(quarter))
    odd = bits("ne", bits("and", quadrant, bits.integer(1)), bits.integer(0))
    sign = bits("and", bits("shl", quadrant, bits.integer(30)), bits.integer(-(1 << 31)))
    return f.cast(bits("xor", bits.cast(build.select(odd, cosine, sine)), sign))


def _sin(build: Builder, x: int) -> int:
    return _sine(x, build, 0)


def _cos(build: Builder, x: int) -> int:
    return _sine(x, build, 1)


def _tan(build: Builder, x: int) -> int:
    return build.same("div", _sin(build, x), _cos(build, x))


def _exponential(build: Builder, x: int, base: float) -> int:
    """Returns base ** x for base 2 or e, in either type."""
    dtype = build.dtype(x)
    f = Formula(build, dtype)
    wide = dtype == "float64"
    bias, mantissa = (1022, 52) if wide else (126, 23)
    unit = 1.0 if base == 2 else math.log(2)
    bound = (709.78 if wide else 88.7228) / math.log(base)
    low = (-708.39 if wide else -87.3365) / math.log(base)
    y = f("min", f("max", x, low), bound)
    turns = f("rint", f("mul", y, 1 / unit))
    r = y
    for part in _split(unit, 11 if not wide else 32, 2):
        r = f("sub", r, f("mul", turns, part))
    if base == 2:
        r = f("mul", r, math.log(2))
    terms = [1 / math.factorial(n) for n in range(2, 14)] if wide else EXP
    power = f("add", f("add", f("mul", f("mul", r, r), f.polynomial(r, terms)), r), 1.0)
    bits = f.bits
    exponent = bits("add", build.convert(turns, bits.dtype), bits.integer(bias))
    scale = f.cast(bits("shl", exponent, bits.integer(mantissa)))
    result = f("mul", f("mul", power, scale), 2.0)  # 2**128 is no float32, 2 * 2**127 may be
    result = build.select(f("lt", x, low), f.number(0.0), result)
    return build.select(f("lt", bound, x), f.number(math.inf), result)


def _split(value: float, bits: int, parts: int) -> list[float]:
    """Returns numbers that sum to value, all but the last with few bits."""
    pieces: list[float] = []
    for _ in range(parts - 1):
        fraction, exponent = math.frexp(value)
        pieces.append(math.ldexp(round(fraction * 2**bits), exponent - bits))
        value -= pieces[-1]
    return [*pieces, value]


def _exp(build: Builder, x: int) -> int:
    return _exponential(build, x, math.e)


def _exp2(build: Builder, x: int) -> int:
    return _exponential(build, x, 2.0)


def _log(build: Builder, x: int) -> int:
    dtype = build.dtype(x)
    f = Formula(build, dtype)
    bits, wide = f.bits, dtype == "float64"
    mantissa = 52 if wide else 23
    root = int(np.asarray(math.sqrt(0.5), dtype).view(bits.dtype))
    raw = bits.cast(x)
    exponent = bits("sar", bits("sub", raw, bits.integer(root)), bits.integer(mantissa))
    reduced = f.cast(bits("sub", raw, bits("shl", exponent, bits.integer(mantissa))))
    turns = build.convert(exponent, dtype)
    r = f("sub", reduced, 1.0)
    square = f("mul", r, r)
    high, low = _split(math.log(2), 11 if not wide else 32, 2)
    if wide:  # 2 atanh(s), s = r / (2 + r)
        s = f("div", r, f("add", r, 2.0))
        z = f("mul", s, s)
        tail = f("mul", f("mul", s, z), f.polynomial(z, [2 / n for n in range(3, 25, 2)]))
        series = f("add", f("mul", s, 2.0), f("add", tail, f("mul", turns, low)))
    else:
        tail = f("add", f("mul", f("mul", r, square), f.polynomial(r, LOG)), f("mul", turns, low))
        series = f("add", r, f("sub", tail, f("mul", square, 0.5)))
    result = f("add", series, f("mul", turns, high))
    tiny = float(np.finfo(dtype).tiny)
    result = build.select(f("lt", x, tiny), f.number(-math.inf), result)  # subnormals are zeros
    result = build.select(f("lt", x, 0.0), f.number(math.nan), result)
    return _at_infinity(f, x, result)


def _at_infinity(f: Formula, x: int, result: int) -> int:
    """Returns result, but x itself where x is infinite or NaN."""
    not_finite = f("le", math.inf, x)
    result = f.build.select(not_finite, x, result)
    return f.build.select(f("ne", x, x), x, result)


def _expm1(build: Builder, x: int) -> int:
    """Kahan's quotient, which cancels the rounding of exp near zero."""
    f = Formula(build, build.dtype(x))
    power = _exp(build, x)
    less = f("sub", power, 1.0)
    result = f("mul", less, f("div", x, _log(build, power)))
    result = build.select(f("eq", less, -1.0), less, result)
    result = build.select(f("eq", power, math.inf), power, result)
    return build.select(f("eq", power, 1.0), x, result)


def _log1p(build: Builder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    more = f("add", x, 1.0)
    result = f("mul", _log(build, more), f("div", x, f("sub", more, 1.0)))
    result = build.select(f("eq", more, math.inf), more, result)
    result = build.select(f("eq", more, 0.0), f.number(-math.inf), result)
    return build.select(f("eq", more, 1.0), x, result)


def _tanh(build: Builder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    size = f("abs", x)
    square = f("mul", x, x)
    small = f("add", f("mul", f("mul", f.polynomial(square, TANH), square), x), x)
    rest = f("div", 2.0, f("add", _exp(build, f("add", size, size)), 1.0))
    large = f("sub", 1.0, rest)
    large = build.select(f("lt", x, 0.0), f("neg", large), large)
    return build.select(f("lt", size, 0.625), small, large)


def _logistic(build: Builder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    return f("recip", f("add", _exp(build, f("neg", x)), 1.0))


def _sinh(build: Builder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    less = _expm1(build, f("abs", x))
    size = f("mul", f("add", less, f("div", less, f("add", less, 1.0))), 0.5)
    size = build.select(f("eq", less, math.inf), less, size)
    return build.select(f("lt", x, 0.0), f("neg", size), size)


def _cosh(build: Builder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    half = f("mul", _exp(build, f("abs", x)), 0.5)
    return f("add", half, f("div", 0.25, half))


def _atan(build: Builder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    size = f("abs", x)
    far, middle = f("lt", 2.414213562373095, size), f("lt", 0.4142135623730950, size)
    inner = f("div", f("sub", size, 1.0), f("add", size, 1.0))
    r = build.select(far, f("neg", f("recip", size)), build.select(middle, inner, size))
    offset = build.select(middle, f.number(math.pi / 4), f.number(0.0))
    offset = build.select(far, f.number(math.pi / 2), offset)
    square = f("mul", r, r)
    angle = f("add", f("mul", f("mul", f.polynomial(square, ATAN), square), r), r)
    return _with_sign(build, f("add", offset, angle), x)


def _with_sign(build: Builder, size: int, like: int) -> int:
    """Returns size with the sign bit of `like`, zeros and NaN included."""
    f = Formula(build, build.dtype(size))
    bits = f.bits
    top = bits.integer(-(1 << (31 if f.dtype == "float32" else 63)))
    sign = bits("and", bits.cast(like), top)
    return f.cast(bits("xor", bits.cast(f("abs", size)), sign))


def _atan2(build: Builder, y: int, x: int) -> int:
    f = Formula(build, build.dtype(y))
    size_x, size_y = f("abs", x), f("abs", y)
    steep = f("lt", size_x, size_y)
    large, small = f("max", size_x, size_y), f("min", size_x, size_y)
    ratio = f("div", small, large)
    ratio = build.select(f("eq", large, 0.0), f.number(0.0), ratio)
    ratio = build.select(f("eq", small, math.inf), f.number(1.0), ratio)
    angle = _atan(build, ratio)
    angle = build.select(steep, f("sub", math.pi / 2, angle), angle)
    bits = f.bits
    negative = bits("lt", bits.cast(x), bits.integer(0))
    angle = build.select(negative, f("sub", math.pi, angle), angle)
    return _with_sign(build, angle, y)


def _asin(build: Builder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    size = f("abs", x)
    large = f("lt", 0.5, size)
    square = build.select(large, f("mul", f("sub", 1.0, size), 0.5), f("mul", x, x))
    r = build.select(large, f("sqrt", square), size)
    angle = f("add", f("mul", f("mul", f.polynomial(square, ASIN), square), r), r)
    angle = build.select(large, f("sub", math.pi / 2, f("add", angle, angle)), angle)
    return _with_sign(build, angle, x)


def _acos(build: Builder, x: int) -> int:
    """By halves where |x| is large, since pi / 2 - asin(x) would cancel."""
    f = Formula(build, build.dtype(x))
    half = f("sqrt", f("mul", f("sub", 1.0, f("abs", x)), 0.5))
    twice = _asin(build, half)
    twice = f("add", twice, twice)
    near = build.select(f("lt", x, 0.0), f("sub", math.pi, twice), twice)
    return build.select(f("lt", 0.5, f("abs", x)), near, f("sub", math.pi / 2, _asin(build, x)))


def _asinh(build: Builder, x: int) -> int:
    """log1p(x + x^2 / (1 + sqrt(1 + x^2))), which keeps small arguments exact."""
    f = Formula(build, build.dtype(x))
    size = f("abs", x)
    square = f("mul", size, size)
    extra = f("div", square, f("add", f("sqrt", f("add", square, 1.0)), 1.0))
    near = _log1p(build, f("add", size, extra))
    far = f("add", _log(build, size), math.log(2))
    return _with_sign(build, build.select(f("lt", 1e8, size), far, near), x)


def _acosh(build: Builder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    less = f("sub", x, 1.0)
    root = f("sqrt", f("mul", less, f("add", x, 1.0)))
    near = _log1p(build, f("add", less, root))
    return build.select(f("lt", 1e8, x), f("add", _log(build, x), math.log(2)), near)


def _atanh(build: Builder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    size = f("abs", x)
    ratio = f("div", f("add", size, size), f("sub", 1.0, size))
    return _with_sign(build, f("mul", _log1p(build, ratio), 0.5), x)


def _pow(build: Builder, x: int, y: int) -> int:
    """exp(y log |x|) in float64, with the cases of the C standard."""
    f = Formula(build, build.dtype(x))
    wide = Formula(build, "float64")
    size = build.convert(f("abs", x), "float64")
    power = wide("mul", build.convert(y, "float64"), _log(build, size))
    result = build.convert(_exp(build, power), f.dtype)
    whole = f("eq", f("floor", y), y)
    half = f("mul", y, 0.5)
    odd = build.same("and", whole, f("ne", f("floor", half), half))
    bits = f.bits
    negative = bits("lt", bits.cast(x), bits.integer(0))
    flip = build.same("and", negative, odd)
    result = build.select(flip, f("neg", result), result)
    invalid = build.same("and", f("lt", x, 0.0), build.same("not", whole))
    invalid = build.same("and", invalid, f("lt", -math.inf, x))
    result = build.select(invalid, f.number(math.nan), result)
    one = build.same("or", f("eq", x, 1.0), f("eq", y, 0.0))
    infinite = f("eq", f("abs", y), math.inf)
    one = build.same("or", one, build.same("and", f("eq", x, -1.0), infinite))
    return build.select(one, f.number(1.0), result)


def _cbrt(build: Builder, x: int) -> int:
    dtype = build.dtype(x)
    size = build.convert(build.same("abs", x), "float64")
    wide = Formula(build, "float64")
    root = build.convert(_exp(build, wide("mul", _log(build, size), 1 / 3)), dtype)
    return _with_sign(build, root, x)


EXPANSIONS: dict[str, Callable[..., int]] = {
    "sin": _sin, "cos": _cos, "tan": _tan, "exp": _exp, "exp2": _exp2, "log": _log,
    "expm1": _expm1, "log1p": _log1p, "tanh": _tanh, "logistic": _logistic, "sinh": _sinh,
    "cosh": _cosh, "atan": _atan, "atan2": _atan2, "asin": _asin, "acos": _acos, "asinh": _asinh,
    "acosh": _acosh, "atanh": _atanh, "pow": _pow, "cbrt": _cbrt,
}  # fmt: skip


class Expander(Builder):
    """Adds nodes to a graph, with every function that has an expansion written out."""

    def make(self, op: str, dtype: str, args: tuple[int, ...], data: object = None) -> int:
        """Returns a node, or the nodes that it expands to."""
        expansion = EXPANSIONS.get(op)
        if expansion is None or all(self.graph.value(arg) is not None for arg in args):
            return super().make(op, dtype, args, data)
        if dtype == "float32" or op in ("exp", "exp2", "log"):
            return expansion(self, *args)
        return super().make(op, dtype, args, data)
