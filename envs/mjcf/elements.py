"""Elements of MJCF as text: numbers with all their digits, and defaults left out."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

# What MuJoCo takes for where it is not written.
SOLREF, SOLIMP = (0.02, 1.0), (0.9, 0.95, 0.001, 0.5, 2.0)
GREY = (0.5, 0.5, 0.5, 1.0)


def numbers(values: Any) -> str:
    """Returns numbers in the fewest digits that MuJoCo reads as the same numbers."""
    array = np.atleast_1d(np.asarray(values))
    if array.dtype == np.float32:
        return " ".join(_number(float(str(value))) for value in array)
    return " ".join(_number(float(value)) for value in array)


def unlike(values: Mapping[str, tuple[Any, Any]]) -> dict[str, str]:
    """Returns attributes that differ from MuJoCo's defaults.

    Args:
      values: of each attribute what it is, and what MuJoCo takes it for where it is not written.
    """
    return {
        name: numbers(value)
        for name, (value, default) in values.items()
        if not np.array_equal(np.atleast_1d(value), np.atleast_1d(default))
    }


def polynomial(linear: Any, higher: Any, place: int) -> Any:
    """Returns a law's coefficients: the linear one, and the higher ones if there are any."""
    more = np.atleast_1d(higher[place])
    return np.array([linear[place], *(more if np.any(more) else ())])


def element(
    tag: str, attributes: Mapping[str, str | None], inside: Sequence[str] = ()
) -> list[str]:
    """Returns the lines of an element; attributes that are None are left out."""
    shown = "".join(
        f" {name}={quoteattr(value)}" for name, value in attributes.items() if value is not None
    )
    if not inside:
        return [f"<{tag}{shown}/>"]
    return [f"<{tag}{shown}>", *(f"  {line}" for line in inside), f"</{tag}>"]


def section(tag: str, inside: Iterable[Sequence[str]]) -> list[str]:
    """Returns the lines of an element that is left out where nothing is in it."""
    lines = [line for each in inside for line in each]
    return element(tag, {}, lines) if lines else []


def _number(value: float) -> str:
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)
