"""Functions that no CPU has an instruction for, written out before code is generated.

`pow` and `cbrt` go through float64; the other functions are refused in that type.
"""

import math
from collections.abc import Callable

from mjxwalk.engines.lanes.errors import CannotCompileError
from mjxwalk.engines.lanes.ir.builder import GraphBuilder
from mjxwalk.engines.lanes.ir.elementary import Formula, cos, exp, exp2, log, sin, tan
from mjxwalk.engines.lanes.ir.graph import Graph
from mjxwalk.engines.lanes.ir.simplify import RULES

# Cephes, single precision, as in `elementary`
TANH = (-3.33332819422e-1, 1.33314422036e-1, -5.37397155531e-2, 2.06390887954e-2, -5.70498872745e-3)
ATAN = (-3.33329491539e-1, 1.99777106478e-1, -1.38776856032e-1, 8.05374449538e-2)
ASIN = (1.6666752422e-1, 7.4953002686e-2, 4.5470025998e-2, 2.4181311049e-2, 4.2163199048e-2)

# Eigen's, single precision (https://eigen.tuxfamily.org, generic_fast_erf)
ERF_ABOVE = (-1.60960333262415e-2, -2.95459980854025e-3, -7.34990630326855e-4,
             -5.69250639462346e-5, -2.10102402082508e-6, 2.77068142495902e-8,
             -2.72614225801306e-10)  # fmt: skip
ERF_BELOW = (-1.42647390514189e-2, -7.37332916720468e-3, -1.68282697438203e-3,
             -2.13374055278905e-4, -1.45660718464996e-5)  # fmt: skip

# Cephes, single precision (erfcf): in 1 / x^2, up to 2 and beyond
ERFC_NEAR = (5.638259427386472e-1, -2.741127028184656e-1, 3.404879937665872e-1,
             -4.944515323274145e-1, 6.210004621745983e-1, -5.824733027278666e-1,
             3.687424674597105e-1, -1.387039388740657e-1, 2.326819970068386e-2)  # fmt: skip
ERFC_FAR = (5.641895067754075e-1, -2.820767439740514e-1, 4.218463358204948e-1,
            -1.015265279202700, 2.921019019210786, -7.495518717768503, 12.97719955372516,
            -10.47766399936249)  # fmt: skip

# M. Giles (2010), Approximating the erfinv function, GPU Computing Gems 2: single precision
ERF_INV_MIDDLE = (1.50140941, 0.246640727, -0.00417768164, -0.00125372503, 0.00021858087,
                  -4.39150654e-6, -3.5233877e-6, 3.43273939e-7, 2.81022636e-8)  # fmt: skip
ERF_INV_TAIL = (2.83297682, 1.00167406, 0.00943887047, -0.0076224613, 0.00573950773,
                -0.00367342844, 0.00134934322, 0.000100950558, -0.000200214257)  # fmt: skip


def _expm1(build: GraphBuilder, x: int) -> int:
    """Kahan's quotient, which cancels the rounding of exp near zero."""
    f = Formula(build, build.dtype(x))
    power = exp(build, x)
    less = f("sub", power, 1.0)
    result = f("mul", less, f("div", x, log(build, power)))
    result = build.select(f("eq", less, -1.0), less, result)
    result = build.select(f("eq", power, math.inf), power, result)
    return build.select(f("eq", power, 1.0), x, result)


def _log1p(build: GraphBuilder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    more = f("add", x, 1.0)
    result = f("mul", log(build, more), f("div", x, f("sub", more, 1.0)))
    result = build.select(f("eq", more, math.inf), more, result)
    result = build.select(f("eq", more, 0.0), f.number(-math.inf), result)
    return build.select(f("eq", more, 1.0), x, result)


def _tanh(build: GraphBuilder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    size = f("abs", x)
    square = f("mul", x, x)
    small = f("add", f("mul", f("mul", f.polynomial(square, TANH), square), x), x)
    rest = f("div", 2.0, f("add", exp(build, f("add", size, size)), 1.0))
    large = f("sub", 1.0, rest)
    large = build.select(f("lt", x, 0.0), f("neg", large), large)
    return build.select(f("lt", size, 0.625), small, large)


def _logistic(build: GraphBuilder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    return f("recip", f("add", exp(build, f("neg", x)), 1.0))


def _sinh(build: GraphBuilder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    less = _expm1(build, f("abs", x))
    size = f("mul", f("add", less, f("div", less, f("add", less, 1.0))), 0.5)
    size = build.select(f("eq", less, math.inf), less, size)
    return build.select(f("lt", x, 0.0), f("neg", size), size)


def _cosh(build: GraphBuilder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    half = f("mul", exp(build, f("abs", x)), 0.5)
    return f("add", half, f("div", 0.25, half))


def _atan(build: GraphBuilder, x: int) -> int:
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


def _with_sign(build: GraphBuilder, size: int, like: int) -> int:
    """Returns size with the sign bit of `like`, zeros and NaN included."""
    f = Formula(build, build.dtype(size))
    bits = f.bits
    top = bits.integer(-(1 << (31 if f.dtype == "float32" else 63)))
    sign = bits("and", bits.cast(like), top)
    return f.cast(bits("xor", bits.cast(f("abs", size)), sign))


def _atan2(build: GraphBuilder, y: int, x: int) -> int:
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


def _asin(build: GraphBuilder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    size = f("abs", x)
    large = f("lt", 0.5, size)
    square = build.select(large, f("mul", f("sub", 1.0, size), 0.5), f("mul", x, x))
    r = build.select(large, f("sqrt", square), size)
    angle = f("add", f("mul", f("mul", f.polynomial(square, ASIN), square), r), r)
    angle = build.select(large, f("sub", math.pi / 2, f("add", angle, angle)), angle)
    return _with_sign(build, angle, x)


def _acos(build: GraphBuilder, x: int) -> int:
    """By halves where |x| is large, since pi / 2 - asin(x) would cancel."""
    f = Formula(build, build.dtype(x))
    half = f("sqrt", f("mul", f("sub", 1.0, f("abs", x)), 0.5))
    twice = _asin(build, half)
    twice = f("add", twice, twice)
    near = build.select(f("lt", x, 0.0), f("sub", math.pi, twice), twice)
    return build.select(f("lt", 0.5, f("abs", x)), near, f("sub", math.pi / 2, _asin(build, x)))


def _asinh(build: GraphBuilder, x: int) -> int:
    """log1p(x + x^2 / (1 + sqrt(1 + x^2))), which keeps small arguments exact."""
    f = Formula(build, build.dtype(x))
    size = f("abs", x)
    square = f("mul", size, size)
    extra = f("div", square, f("add", f("sqrt", f("add", square, 1.0)), 1.0))
    near = _log1p(build, f("add", size, extra))
    far = f("add", log(build, size), math.log(2))
    return _with_sign(build, build.select(f("lt", 1e8, size), far, near), x)


def _acosh(build: GraphBuilder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    less = f("sub", x, 1.0)
    root = f("sqrt", f("mul", less, f("add", x, 1.0)))
    near = _log1p(build, f("add", less, root))
    return build.select(f("lt", 1e8, x), f("add", log(build, x), math.log(2)), near)


def _atanh(build: GraphBuilder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    size = f("abs", x)
    ratio = f("div", f("add", size, size), f("sub", 1.0, size))
    return _with_sign(build, f("mul", _log1p(build, ratio), 0.5), x)


def _pow(build: GraphBuilder, x: int, y: int) -> int:
    """exp(y log |x|) in float64, with the cases of the C standard."""
    f = Formula(build, build.dtype(x))
    wide = Formula(build, "float64")
    size = build.convert(f("abs", x), "float64")
    power = wide("mul", build.convert(y, "float64"), log(build, size))
    result = build.convert(exp(build, power), f.dtype)
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


def _cbrt(build: GraphBuilder, x: int) -> int:
    dtype = build.dtype(x)
    size = build.convert(build.same("abs", x), "float64")
    wide = Formula(build, "float64")
    root = build.convert(exp(build, wide("mul", log(build, size), 1 / 3)), dtype)
    return _with_sign(build, root, x)


def _erf(build: GraphBuilder, x: int) -> int:
    """An odd rational function, good to 4e-7; 1 or -1 beyond 4."""
    f = Formula(build, build.dtype(x))
    inside = f("max", f("min", x, 4.0), -4.0)
    square = f("mul", inside, inside)
    above, below = f.polynomial(square, ERF_ABOVE), f.polynomial(square, ERF_BELOW)
    return f("mul", inside, f("div", above, below))


def _erfc(build: GraphBuilder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    size = f("abs", x)
    inverse = f("recip", f("max", size, 1.0))
    square = f("mul", inverse, inverse)
    series = f.polynomial(square, ERFC_FAR)
    series = build.select(f("lt", size, 2.0), f.polynomial(square, ERFC_NEAR), series)
    size = f("min", size, 16.0)  # beyond, it is 0
    raised = f("mul", size, size)
    lost = f("fma", size, size, f("neg", raised))
    tail = f("mul", f("mul", exp(build, f("neg", raised)), inverse), series)
    tail = f("sub", tail, f("mul", tail, lost))
    tail = build.select(f("lt", x, 0.0), f("sub", 2.0, tail), tail)
    return build.select(f("lt", size, 1.0), f("sub", 1.0, _erf(build, x)), tail)


def _erf_inv(build: GraphBuilder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    w = f("neg", _log1p(build, f("neg", f("mul", x, x))))
    middle = f.polynomial(f("sub", w, 2.5), ERF_INV_MIDDLE)
    tail = f.polynomial(f("sub", f("sqrt", w), 3.0), ERF_INV_TAIL)
    result = f("mul", build.select(f("lt", w, 5.0), middle, tail), x)
    infinite = f("mul", x, math.inf)
    return build.select(f("eq", f("abs", x), 1.0), infinite, result)


EXPANSIONS: dict[str, Callable[..., int]] = {
    "sin": sin, "cos": cos, "tan": tan, "exp": exp, "exp2": exp2, "log": log,
    "expm1": _expm1, "log1p": _log1p, "tanh": _tanh, "logistic": _logistic, "sinh": _sinh,
    "cosh": _cosh, "atan": _atan, "atan2": _atan2, "asin": _asin, "acos": _acos, "asinh": _asinh,
    "acosh": _acosh, "atanh": _atanh, "pow": _pow, "cbrt": _cbrt,
    "erf": _erf, "erfc": _erfc, "erf_inv": _erf_inv,
}  # fmt: skip


class LoweringBuilder(GraphBuilder):
    """Adds nodes to a graph, with every function that has an expansion written out."""

    def __init__(self, graph: Graph) -> None:
        super().__init__(graph, RULES)

    def make(self, op: str, dtype: str, args: tuple[int, ...], data: object = None) -> int:
        """Returns a node, or the nodes that it expands to."""
        expansion = EXPANSIONS.get(op)
        if expansion is None or all(self.graph.value(arg) is not None for arg in args):
            return super().make(op, dtype, args, data)
        if dtype == "float32" or op in ("exp", "exp2", "log"):
            return expansion(self, *args)
        raise CannotCompileError(
            f"the lanes engine cannot compile `{op}` of {dtype} numbers; use float32, or "
            "--engine mjx, which runs anything that JAX can trace"
        )
