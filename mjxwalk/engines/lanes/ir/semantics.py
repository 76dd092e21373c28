"""What every scalar operation means, in numpy: the reference that the machine code is tested with.

Constants fold with these functions, in the arithmetic of their own type, and whole arrays whose
values are known while tracing are computed with them at once.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from mjxwalk.engines.lanes.ir.graph import Array

COMMUTATIVE = frozenset(["add", "mul", "max", "min", "and", "or", "xor", "eq", "ne"])
COMPARISONS = frozenset(["lt", "le", "eq", "ne"])


def is_float(dtype: str) -> bool:
    """Returns whether a type name is one of floating point numbers."""
    return dtype.startswith("float")


def is_signed(dtype: str) -> bool:
    """Returns whether a type name is one of signed integers."""
    return dtype.startswith("int")


def convert(x: Array, dtype: str) -> Array:
    """Returns x in another type; floats truncate to integers, clamped to range, and NaN to zero."""
    if is_float(x.dtype.name) and not is_float(dtype) and dtype != "bool":
        limits = np.iinfo(dtype)
        wide = np.nan_to_num(x.astype(np.float64), nan=0.0, posinf=np.inf, neginf=-np.inf)
        whole = np.trunc(wide)
        inside = np.clip(whole, float(limits.min), float(limits.max))
        # The largest int64 is no float64, so that end is put in by hand.
        converted = np.where(inside >= float(limits.max), 0.0, inside).astype(dtype)
        return np.where(inside >= float(limits.max), np.array(limits.max, dtype), converted)
    return x.astype(dtype)


def bitcast(x: Array, dtype: str) -> Array:
    """Returns the same bits read as another type of the same size."""
    return np.ascontiguousarray(x).view(dtype).reshape(x.shape)


def divide(x: Array, y: Array) -> Array:
    """Returns x / y; integers truncate towards zero, and give -1 where y is 0, as XLA's do."""
    if is_float(x.dtype.name):
        return np.asarray(np.divide(x, y))
    safe = np.where(y == 0, np.ones_like(y), y)
    quotient = np.floor_divide(x, safe)
    towards_zero = (np.remainder(x, safe) != 0) & ((x < 0) != (safe < 0))
    minus_one = np.array(-1).astype(x.dtype)
    return np.where(y == 0, minus_one, quotient + towards_zero.astype(x.dtype))


def remainder(x: Array, y: Array) -> Array:
    """Returns the remainder with the sign of x; integers give x where y is 0, as XLA's do."""
    if is_float(x.dtype.name):
        return np.asarray(np.fmod(x, y))
    safe = np.where(y == 0, np.ones_like(y), y)
    return np.where(y == 0, x, np.fmod(x, safe))


def _shift(x: Array, y: Array, kind: str) -> Array:
    bits = x.dtype.itemsize * 8
    unsigned = np.dtype(f"uint{bits}")
    distance = np.asarray(y).astype(unsigned)
    inside = distance < bits
    distance = np.where(inside, distance, 0).astype(unsigned)
    if kind == "sar":
        signed = x.view(f"int{bits}")
        filled = np.where(inside, signed >> distance.view(signed.dtype), signed >> (bits - 1))
        return filled.astype(signed.dtype).view(x.dtype)
    moved = x.view(unsigned) << distance if kind == "shl" else x.view(unsigned) >> distance
    return np.where(inside, moved, 0).astype(unsigned).view(x.dtype)


def _special(name: str) -> Callable[[Array], Array]:
    def evaluate(x: Array) -> Array:
        from scipy import special  # half a second, for what few models have

        return np.asarray(getattr(special, name)(x.astype(np.float64))).astype(x.dtype)

    return evaluate


REFERENCE: dict[str, Callable[..., Any]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": divide,
    "rem": remainder,
    "neg": np.negative,
    "abs": np.abs,
    "max": np.maximum,
    "min": np.minimum,
    "sqrt": np.sqrt,
    "rsqrt": lambda x: (1 / np.sqrt(x)).astype(x.dtype),
    "recip": lambda x: (1 / x).astype(x.dtype),
    "floor": np.floor,
    "ceil": np.ceil,
    "rint": np.rint,
    "fma": lambda x, y, z: (x.astype(np.float64) * y + z).astype(x.dtype),
    "lt": np.less,
    "le": np.less_equal,
    "eq": np.equal,
    "ne": np.not_equal,
    "and": np.bitwise_and,
    "or": np.bitwise_or,
    "xor": np.bitwise_xor,
    "not": np.invert,
    "shl": lambda x, y: _shift(x, y, "shl"),
    "shr": lambda x, y: _shift(x, y, "shr"),
    "sar": lambda x, y: _shift(x, y, "sar"),
    "select": np.where,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "asinh": np.arcsinh,
    "acosh": np.arccosh,
    "atanh": np.arctanh,
    "exp": np.exp,
    "exp2": np.exp2,
    "expm1": np.expm1,
    "log": np.log,
    "log1p": np.log1p,
    "logistic": lambda x: (1 / (1 + np.exp(-x))).astype(x.dtype),
    "pow": np.power,
    "cbrt": np.cbrt,
    "erf": _special("erf"),
    "erfc": _special("erfc"),
    "erf_inv": _special("erfinv"),
}


def evaluate(op: str, dtype: str, *args: Any) -> Array:
    """Returns the operation on known numbers, in the result's own type and without warnings."""
    with np.errstate(all="ignore"):
        if op == "convert":
            return convert(np.asarray(args[0]), dtype)
        if op == "bitcast":
            return bitcast(np.asarray(args[0]), dtype)
        return np.asarray(REFERENCE[op](*map(np.asarray, args))).astype(dtype, copy=False)
