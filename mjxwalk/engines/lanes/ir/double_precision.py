"""sin, cos, atan and powers in float64, where they are not those of float32 with more terms.

sin and cos reduce their argument exactly enough up to 1e6; beyond, the error grows with the
argument and the result stays within [-1, 1]. Powers take the logarithm in two numbers, since an
error of it is multiplied by the exponent: T. J. Dekker (1971), A floating-point technique for
extending the available precision.
"""

import math

import numpy as np

from mjxwalk.engines.lanes.ir.builder import GraphBuilder
from mjxwalk.engines.lanes.ir.elementary import LN_2_IN_TWO, Formula, exp, log, sine_near_zero

# fdlibm (Sun Microsystems, e_rem_pio2.c): pi / 2 in 33, 33 and 53 bits
HALF_PI = (1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21)
SIN = tuple((-1) ** n / math.factorial(2 * n + 1) for n in range(1, 9))
COS = tuple((-1) ** n / math.factorial(2 * n) for n in range(2, 10))
# Cephes (Moshier, https://www.netlib.org/cephes/, atan.c)
ATAN_ABOVE = (-6.485021904942025371773e1, -1.228866684490136173410e2, -7.500855792314704667340e1,
              -1.615753718733365076637e1, -8.750608600031904122785e-1)  # fmt: skip
ATAN_BELOW = (1.945506571482613964425e2, 4.853903996359136964868e2, 4.328810604912902668951e2,
              1.650270098316988542046e2, 2.485846490142306297962e1, 1.0)  # fmt: skip
LOST_OF_HALF_PI = 6.123233995736765886130e-17


def sine(build: GraphBuilder, x: int, quarter: int) -> int:
    """Returns sin(x + quarter * pi / 2)."""
    f = Formula(build, "float64")
    turns = f("rint", f("mul", x, 2 / math.pi))
    r = x
    for part in HALF_PI:
        r = f("sub", r, f("mul", turns, part))
    return sine_near_zero(f, r, SIN, COS, build.convert(turns, "int64"), quarter)


def atan_of_size(build: GraphBuilder, size: int) -> int:
    """Returns the angle whose tangent is a number that is not negative."""
    f = Formula(build, "float64")
    far, middle = f("lt", math.sqrt(2) + 1, size), f("lt", 0.66, size)
    inner = f("div", f("sub", size, 1.0), f("add", size, 1.0))
    r = build.select(far, f("neg", f("div", 1.0, size)), build.select(middle, inner, size))
    offset = build.select(far, f.number(math.pi / 2), f.number(math.pi / 4))
    lost = build.select(far, f.number(LOST_OF_HALF_PI), f.number(LOST_OF_HALF_PI / 2))
    square = f("mul", r, r)
    ratio = f("div", f.polynomial(square, ATAN_ABOVE), f.polynomial(square, ATAN_BELOW))
    angle = f("add", f("mul", f("mul", ratio, square), r), r)
    return build.select(middle, f("add", offset, f("add", angle, lost)), angle)


def power_of_size(build: GraphBuilder, size: int, y: int) -> int:
    """Returns size ** y for a number that is not negative."""
    f = Formula(build, "float64")
    high, low = _exact_log(build, size)
    regular = build.same("and", f("le", float(np.finfo("float64").tiny), size),
                         f("lt", size, math.inf))  # fmt: skip
    high = build.select(regular, high, log(build, size))
    product = f("mul", y, high)
    rest = f("add", f("fma", y, high, f("neg", product)), f("mul", y, low))
    known = build.same("and", regular, f("lt", f("abs", product), 1000.0))
    rest = build.select(known, rest, f.number(0.0))
    power = exp(build, product)
    more = f("add", power, f("mul", power, rest))
    return build.select(f("lt", power, math.inf), more, power)


def _exact_log(build: GraphBuilder, x: int) -> tuple[int, int]:
    """Returns the logarithm of a positive number as a number and what rounding lost of it.

    It is 2 atanh(s) of s = r / (2 + r), and so many times log(2).
    """
    f = Formula(build, "float64")
    bits = f.bits
    root = int(np.asarray(math.sqrt(0.5)).view(np.int64))
    raw = bits.cast(x)
    exponent = bits("sar", bits("sub", raw, bits.integer(root)), bits.integer(52))
    r = f("sub", f.cast(bits("sub", raw, bits("shl", exponent, bits.integer(52)))), 1.0)
    turns = build.convert(exponent, "float64")
    below = f("add", r, 2.0)
    lost = f("sub", r, f("sub", below, 2.0))
    s = f("div", r, below)
    rest = f("sub", f("fma", f("neg", s), below, r), f("mul", s, lost))
    rest = f("div", rest, below)
    square = f("mul", s, s)
    series = f.polynomial(square, [2 / n for n in range(3, 25, 2)])
    tail = f("mul", f("mul", s, square), series)
    first, second = f("mul", turns, LN_2_IN_TWO[0]), f("mul", s, 2.0)
    high = f("add", first, second)
    part = f("sub", high, first)
    rounding = f("add", f("sub", first, f("sub", high, part)), f("sub", second, part))
    low = f("add", f("add", tail, f("mul", rest, 2.0)), f("mul", turns, LN_2_IN_TWO[1]))
    low = f("add", rounding, low)
    total = f("add", high, low)
    return total, f("sub", low, f("sub", total, high))
