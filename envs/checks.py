"""Checks of settings, made when a settings object is built."""

import math
from typing import Any


def positive(settings: Any, *fields: str) -> None:
    """Raises ValueError unless each named field is a finite number above zero."""
    for field in fields:
        value = getattr(settings, field)
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"{field} must be a number above 0, got {value}")


def not_negative(settings: Any, *fields: str) -> None:
    """Raises ValueError unless each named field is a finite number, zero or above."""
    for field in fields:
        value = getattr(settings, field)
        if not (math.isfinite(value) and value >= 0):
            raise ValueError(f"{field} must be 0 or above, got {value}")
