"""The error function, what it lacks to 1, and its inverse, in float32."""

import math

from mjxwalk.engines.lanes.ir.builder import GraphBuilder
from mjxwalk.engines.lanes.ir.elementary import Formula, exp, log1p

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


def erf(build: GraphBuilder, x: int) -> int:
    """Returns erf(x): an odd rational function, good to 4e-7; 1 or -1 beyond 4."""
    f = Formula(build, build.dtype(x))
    inside = f("max", f("min", x, 4.0), -4.0)
    square = f("mul", inside, inside)
    above, below = f.polynomial(square, ERF_ABOVE), f.polynomial(square, ERF_BELOW)
    return f("mul", inside, f("div", above, below))


def erfc(build: GraphBuilder, x: int) -> int:
    """Returns 1 - erf(x)."""
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
    return build.select(f("lt", size, 1.0), f("sub", 1.0, erf(build, x)), tail)


def erf_inv(build: GraphBuilder, x: int) -> int:
    """Returns the number whose erf is x."""
    f = Formula(build, build.dtype(x))
    w = f("neg", log1p(build, f("neg", f("mul", x, x))))
    middle = f.polynomial(f("sub", w, 2.5), ERF_INV_MIDDLE)
    tail = f.polynomial(f("sub", f("sqrt", w), 3.0), ERF_INV_TAIL)
    result = f("mul", build.select(f("lt", w, 5.0), middle, tail), x)
    infinite = f("mul", x, math.inf)
    return build.select(f("eq", f("abs", x), 1.0), infinite, result)
