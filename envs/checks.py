"""Checks of settings, made when a settings object is built."""

import math
from typing import Any

# ours: smaller and larger ones leave float32, in which all is computed, without digits for the rest
SMALLEST, LARGEST = 1e-6, 1e10
MOST = 2**31 - 1  # of anything that is counted; JAX counts in 32 bits
MOST_STEPS = 1 << 24  # of a trial; float32, in which it counts time, tells no more of them apart
MOST_NODES = 1 << 24  # of a ground; as far as float32 finds its way among them


def positive(settings: Any, *fields: str) -> None:
    """Raises ValueError unless each named field is a finite number above zero."""
    for field in fields:
        value = getattr(settings, field)
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"{field} must be a number above 0, got {value}")
        if not SMALLEST <= value <= LARGEST:
            raise ValueError(f"{field} must be from {SMALLEST:g} to {LARGEST:g}, got {value}")


def not_negative(settings: Any, *fields: str) -> None:
    """Raises ValueError unless each named field is a finite number, zero or above."""
    for field in fields:
        value = getattr(settings, field)
        if not (math.isfinite(value) and value >= 0):
            raise ValueError(f"{field} must be 0 or above, got {value}")
        if value > LARGEST:
            raise ValueError(f"{field} must be at most {LARGEST:g}, got {value}")


def count(settings: Any, *fields: str) -> None:
    """Raises ValueError unless each named field is a number of things, at least one."""
    for field in fields:
        value = getattr(settings, field)
        if not 1 <= value <= MOST:
            raise ValueError(f"{field} must be from 1 to {MOST:,}, got {value}")


def one_of(settings: Any, field: str, known: tuple[str, str]) -> None:
    """Raises ValueError unless a field is one of two words."""
    value = getattr(settings, field)
    if value not in known:
        raise ValueError(f'{field} must be "{known[0]}" or "{known[1]}", got "{value}"')


def finite(settings: Any, *fields: str) -> None:
    """Raises ValueError unless each named field is a number that float32 holds well."""
    for field in fields:
        value = getattr(settings, field)
        if not abs(value) <= LARGEST:
            raise ValueError(f"{field} must be from {-LARGEST:g} to {LARGEST:g}, got {value}")


def span(mean: float, spread: float) -> str:
    """Returns the numbers that trials draw, in words."""
    return f"{mean - spread:g} to {mean + spread:g}" if spread else f"{mean:g}"


def steps(settings: Any) -> None:
    """Raises ValueError unless the steps of a trial can be counted."""
    num = settings.max_time / settings.timestep
    if num < 1:
        raise ValueError(
            f"max_time must be a timestep of {settings.timestep} s at least, got "
            f"{settings.max_time} s"
        )
    if num > MOST_STEPS:
        raise ValueError(
            f"max_time must be at most {MOST_STEPS:,} timesteps, got {settings.max_time} s at "
            f"{settings.timestep} s each, which are {num:.3g}"
        )


def nodes(settings: Any, *fields: str) -> None:
    """Raises ValueError unless a ground's nodes, spaced evenly, can be counted."""
    num = math.prod(getattr(settings, field) / settings.spacing for field in fields)
    if num > MOST_NODES:
        raise ValueError(
            f"{' times '.join(fields)} must hold at most {MOST_NODES:,} nodes, got "
            f"{' and '.join(f'{getattr(settings, field)} m' for field in fields)} with one every "
            f"{settings.spacing} m, which are {num:.3g}"
        )
