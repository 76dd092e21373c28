"""sin, cos, exp and log, from which all others are made, as graphs of operations that CPUs have.

Polynomials are those of Cephes (Moshier, https://www.netlib.org/cephes/, single precision), good
to about two units in the last place; float64 has longer series. Since they are made of nodes, sin
and cos of one angle share their range reduction without being told to.

sin, cos and tan reduce their argument exactly enough up to 1e5; beyond, the error grows with the
argument and the result stays within [-1, 1]. In float64 they are those of `double_precision`.
"""

import math
from collections.abc import Sequence

import numpy as np

from mjxwalk.engines.lanes.ir.builder import GraphBuilder

HALF_PI_FEW_BITS = (1.5703125, 4.84466552734375e-4, -6.39757837817001e-7)  # 8, 8 and 24 bits
SIN = (-1.6666654611e-1, 8.3321608736e-3, -1.9515295891e-4)
COS = (4.166664568298827e-2, -1.388731625493765e-3, 2.443315711809948e-5)
EXP = (0.5, 1.6666665459e-1, 4.1665795894e-2, 8.3334519073e-3, 1.3981999507e-3, 1.9875691500e-4)
LOG = (3.3333331174e-1, -2.4999993993e-1, 2.0000714765e-1, -1.6668057665e-1, 1.4249322787e-1,
       -1.2420140846e-1, 1.1676998740e-1, -1.1514610310e-1, 7.0376836292e-2)  # fmt: skip
LN_2_IN_TWO = (0.6931471803691238, 1.9082149292705877e-10)  # fdlibm, e_log.c: 33 bits, the rest
ROUND_BY_ADDING = 12582912.0  # 1.5 * 2**23: adding it leaves the nearest integer in the low bits


class Formula:
    """Writes formulas over one type: numbers become constants as they are met."""

    def __init__(self, build: GraphBuilder, dtype: str) -> None:
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


def _sine(x: int, build: GraphBuilder, quarter: int) -> int:
    """Returns sin(x + quarter * pi / 2)."""
    f = Formula(build, "float32")
    shifted = f("add", f("mul", x, 2 / math.pi), ROUND_BY_ADDING)
    turns = f("sub", shifted, ROUND_BY_ADDING)
    r = x
    for part in HALF_PI_FEW_BITS:
        r = f("sub", r, f("mul", turns, part))
    return sine_near_zero(f, r, SIN, COS, f.bits.cast(shifted), quarter)


def sine_near_zero(
    f: Formula,
    r: int,
    sin: Sequence[float],
    cos: Sequence[float],
    turns: int,
    quarter: int,
) -> int:
    """Returns sin(r + (turns + quarter) * pi / 2).

    Args:
      f: formulas over the type of r.
      r: an angle up to pi / 4 either way, but for what reduction lost.
      sin: coefficients of (sin(r) - r) / r^3 in r^2.
      cos: coefficients of (cos(r) - 1 + r^2 / 2) / r^4 in r^2.
      turns: node of the quarter turns that r leaves out, an integer whose low two bits count.
      quarter: further ones.
    """
    bits = f.bits
    top = 8 * np.dtype(f.dtype).itemsize - 1
    r = f("min", f("max", r, -0.79), 0.79)  # what reduction lost must not leave [-1, 1]
    square = f("mul", r, r)
    sine = f("add", f("mul", f("mul", f.polynomial(square, sin), square), r), r)
    tail = f("mul", f("mul", f.polynomial(square, cos), square), square)
    cosine = f("add", f("add", tail, f("mul", square, -0.5)), 1.0)
    quadrant = bits("add", turns, bits.integer(quarter))
    odd = bits("ne", bits("and", quadrant, bits.integer(1)), bits.integer(0))
    sign = bits("and", bits("shl", quadrant, bits.integer(top - 1)), bits.integer(-(1 << top)))
    return f.cast(bits("xor", bits.cast(f.build.select(odd, cosine, sine)), sign))


def sin(build: GraphBuilder, x: int) -> int:
    """Returns sin(x)."""
    return _sine(x, build, 0)


def cos(build: GraphBuilder, x: int) -> int:
    """Returns cos(x)."""
    return _sine(x, build, 1)


def tan(build: GraphBuilder, x: int) -> int:
    """Returns tan(x)."""
    return build.same("div", sin(build, x), cos(build, x))


def _exponential(build: GraphBuilder, x: int, base: float) -> int:
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
    exact = wide and base != 2  # the rounding of log(2) itself shows
    for part in LN_2_IN_TWO if exact else _split(unit, 11 if not wide else 32, 2):
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


def exp(build: GraphBuilder, x: int) -> int:
    """Returns e ** x."""
    return _exponential(build, x, math.e)


def exp2(build: GraphBuilder, x: int) -> int:
    """Returns 2 ** x."""
    return _exponential(build, x, 2.0)


def log(build: GraphBuilder, x: int) -> int:
    """Returns the natural logarithm of x."""
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


def expm1(build: GraphBuilder, x: int) -> int:
    """Returns e ** x - 1: Kahan's quotient, which cancels the rounding of exp near zero."""
    f = Formula(build, build.dtype(x))
    power = exp(build, x)
    less = f("sub", power, 1.0)
    result = f("mul", less, f("div", x, log(build, power)))
    result = build.select(f("eq", less, -1.0), less, result)
    result = build.select(f("eq", power, math.inf), power, result)
    return build.select(f("eq", power, 1.0), x, result)


def log1p(build: GraphBuilder, x: int) -> int:
    """Returns log(1 + x)."""
    f = Formula(build, build.dtype(x))
    more = f("add", x, 1.0)
    result = f("mul", log(build, more), f("div", x, f("sub", more, 1.0)))
    result = build.select(f("eq", more, math.inf), more, result)
    result = build.select(f("eq", more, 0.0), f.number(-math.inf), result)
    return build.select(f("eq", more, 1.0), x, result)
