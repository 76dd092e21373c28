"""Strategies as compiled functions, since one operation at a time compiles for longer."""

import dataclasses
from typing import Any

import jax


def compiled(strategy: Any) -> Any:
    """Returns a strategy whose every function is compiled, once for the shapes that it is given."""
    functions = {
        field.name: jax.jit(getattr(strategy, field.name))
        for field in dataclasses.fields(strategy)
        if callable(getattr(strategy, field.name))
    }
    return dataclasses.replace(strategy, **functions)
