"""LLVM's names of scalar types, and its text of numbers."""

from typing import Any

import numpy as np

from mjxwalk.engines.lanes.ir.semantics import is_float

SCALAR = {"float32": "float", "float64": "double", "bool": "i1"}


def scalar_type(dtype: str) -> str:
    """Returns LLVM's name of a scalar type."""
    return SCALAR.get(dtype) or f"i{np.dtype(dtype).itemsize * 8}"


def memory_type(dtype: str) -> str:
    """Returns LLVM's name of a scalar type in memory, where a boolean is a byte."""
    return "i8" if dtype == "bool" else scalar_type(dtype)


def short_type(dtype: str) -> str:
    """Returns LLVM's name of a scalar type within the name of an intrinsic."""
    return {"float32": "f32", "float64": "f64"}.get(dtype) or scalar_type(dtype)


def literal(value: Any) -> str:
    """Returns LLVM's text of a number."""
    dtype = value.dtype.name
    if is_float(dtype):  # LLVM writes every float with the bits of the double of equal value
        with np.errstate(invalid="ignore"):
            bits = np.asarray(value).astype(np.float64).view(np.uint64)
        return f"0x{int(bits):016X}"
    if dtype == "bool":
        return "true" if value else "false"
    return str(int(value.item()))
