"""Functions that no CPU has an instruction for, written out before code is generated.

`pow` and `cbrt` of float32 go through float64. Those in `SINGLE_ALONE` are refused in float64.
"""

import math
from collections.abc import Callable

from mjxwalk.engines.lanes.errors import CannotCompileError
from mjxwalk.engines.lanes.ir import double_precision, elementary
from mjxwalk.engines.lanes.ir.builder import GraphBuilder
from mjxwalk.engines.lanes.ir.elementary import Formula, exp, exp2, expm1, log, log1p
from mjxwalk.engines.lanes.ir.error_functions import erf, erf_inv, erfc
from mjxwalk.engines.lanes.ir.graph import Graph
from mjxwalk.engines.lanes.ir.simplify import RULES

# Cephes, single precision, as in `elementary`
TANH = (-3.33332819422e-1, 1.33314422036e-1, -5.37397155531e-2, 2.06390887954e-2, -5.70498872745e-3)
ATAN = (-3.33329491539e-1, 1.99777106478e-1, -1.38776856032e-1, 8.05374449538e-2)
ASIN = (1.6666752422e-1, 7.4953002686e-2, 4.5470025998e-2, 2.4181311049e-2, 4.2163199048e-2)

SINGLE_ALONE = ("erf", "erfc", "erf_inv")


def _sin(build: GraphBuilder, x: int) -> int:
    wide = build.dtype(x) == "float64"
    return double_precision.sine(build, x, 0) if wide else elementary.sin(build, x)


def _cos(build: GraphBuilder, x: int) -> int:
    wide = build.dtype(x) == "float64"
    return double_precision.sine(build, x, 1) if wide else elementary.cos(build, x)


def _tan(build: GraphBuilder, x: int) -> int:
    return build.same("div", _sin(build, x), _cos(build, x))


def _tanh(build: GraphBuilder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    size = f("abs", x)
    if f.dtype == "float64":
        less = expm1(build, f("add", x, x))
        small = f("div", less, f("add", less, 2.0))
    else:
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
    less = expm1(build, f("abs", x))
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
    if f.dtype == "float64":
        return _with_sign(build, double_precision.atan_of_size(build, size), x)
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
    if f.dtype == "float64":
        rest = f("mul", f("sub", 1.0, x), f("add", x, 1.0))
        return _atan(build, f("div", x, f("sqrt", rest)))
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
    if f.dtype == "float64":
        half = _atan(build, f("sqrt", f("div", f("sub", 1.0, x), f("add", x, 1.0))))
        return f("add", half, half)
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
    near = log1p(build, f("add", size, extra))
    far = f("add", log(build, size), math.log(2))
    return _with_sign(build, build.select(f("lt", 1e8, size), far, near), x)


def _acosh(build: GraphBuilder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    less = f("sub", x, 1.0)
    root = f("sqrt", f("mul", less, f("add", x, 1.0)))
    near = log1p(build, f("add", less, root))
    return build.select(f("lt", 1e8, x), f("add", log(build, x), math.log(2)), near)


def _atanh(build: GraphBuilder, x: int) -> int:
    f = Formula(build, build.dtype(x))
    size = f("abs", x)
    ratio = f("div", f("add", size, size), f("sub", 1.0, size))
    return _with_sign(build, f("mul", log1p(build, ratio), 0.5), x)


def _pow(build: GraphBuilder, x: int, y: int) -> int:
    """exp(y log |x|) in float64, with the cases of the C standard."""
    f = Formula(build, build.dtype(x))
    wide = Formula(build, "float64")
    if f.dtype == "float64":
        result = double_precision.power_of_size(build, f("abs", x), y)
    else:
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
    root = exp(build, wide("mul", log(build, size), 1 / 3))
    if dtype == "float64":  # Newton's step, but not from zero or infinity
        step = wide("div", wide("sub", root, wide("div", size, wide("mul", root, root))), 3.0)
        inside = build.same("and", wide("lt", 0.0, root), wide("lt", root, math.inf))
        root = build.select(inside, wide("sub", root, step), root)
    root = build.convert(root, dtype)
    return _with_sign(build, root, x)


EXPANSIONS: dict[str, Callable[..., int]] = {
    "sin": _sin, "cos": _cos, "tan": _tan, "exp": exp, "exp2": exp2, "log": log,
    "expm1": expm1, "log1p": log1p, "tanh": _tanh, "logistic": _logistic, "sinh": _sinh,
    "cosh": _cosh, "atan": _atan, "atan2": _atan2, "asin": _asin, "acos": _acos, "asinh": _asinh,
    "acosh": _acosh, "atanh": _atanh, "pow": _pow, "cbrt": _cbrt,
    "erf": erf, "erfc": erfc, "erf_inv": erf_inv,
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
        if dtype == "float32" or op not in SINGLE_ALONE:
            return expansion(self, *args)
        raise CannotCompileError(
            f"the lanes engine cannot compile `{op}` of {dtype} numbers; use float32, or "
            "--engine mjx, which runs anything that JAX can trace"
        )
