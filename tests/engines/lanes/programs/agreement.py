"""Whether lanes and JAX agree on programs, as far as rounding lets two compilers agree."""

from collections.abc import Sequence
from typing import Any

import jax
import numpy as np
from engines.lanes.programs.interpretation import NUM_ERRORS, Plain, Reference
from engines.lanes.programs.program import Kind, Program

from mjxwalk.engines import lanes

NUM_WALKERS = 41  # no multiple of any width
NUM_SHARED = 2  # arguments at the end that all walkers share
NUM_VARIED = 6  # times that the rounding varies

KINDS = (Kind("float32", (3,)), Kind("float32", (3, 3)), Kind("float32", ()), Kind("int32", (3,)),
         Kind("int32", ()), Kind("uint32", (3,)), Kind("bool", (3,)), Kind("bool", ()),
         Kind("float32", (5, 3)), Kind("int32", (6,)))  # fmt: skip
WIDE_KINDS = (Kind("float64", (3,)), Kind("float64", (3, 3)), Kind("float64", ()),
              Kind("int64", (3,)), Kind("float32", (3,)), *KINDS[4:8],
              Kind("float64", (5, 3)), Kind("int32", (6,)))  # fmt: skip


def arguments(kinds: Sequence[Kind], seed: int = 0) -> list[Any]:
    """Returns numbers for all walkers; a few walkers have extreme ones."""
    rng = np.random.default_rng(seed)
    given: list[Any] = []
    for number, (dtype, shape) in enumerate(kinds):
        shared = number >= len(kinds) - NUM_SHARED
        size = shape if shared else (NUM_WALKERS, *shape)
        given.append(_numbers(rng, dtype, size, plain=shared))
    return given


def _numbers(rng: np.random.Generator, dtype: str, size: tuple[int, ...], plain: bool) -> Any:
    if dtype == "bool":
        return rng.random(size) < 0.5
    if dtype.startswith("float"):
        numbers = rng.normal(size=size) * np.where(rng.random(size) < 0.2, 30, 1)
        special = [0.0, -0.0, 1.0, -2.0, np.nan, np.inf, -np.inf, 3e38, 1e-30]
    else:
        limits = np.iinfo(dtype)
        numbers = rng.integers(-4 if limits.min else 0, 9, size)
        special = [limits.min, limits.max, limits.max // 3, 0, -1 if limits.min else 1, 31, 32]
    numbers = numbers.astype(dtype)
    if not plain:
        extreme = rng.random(size) < 0.5
        extreme[8:] = False
        numbers = np.where(extreme, rng.choice(np.array(special, dtype), size), numbers)
    return numbers


def disagreements(programs: Sequence[Program], given: Sequence[Any]) -> list[str]:
    """Returns what lanes and JAX disagree about, a sentence for each program and output."""
    axes: Any = (0,) * (len(given) - NUM_SHARED) + (None,) * NUM_SHARED

    def plain(*inputs: Any) -> Any:
        return [Plain()(program, *inputs) for program in programs]

    def varied(errors: Any, *inputs: Any) -> Any:
        return [Reference(errors)(program, *inputs) for program in programs]

    rng = np.random.default_rng(1)
    errors = rng.uniform(-1, 1, (1 + NUM_VARIED, NUM_ERRORS)).astype(given[0].dtype)
    errors[0] = 0
    within = jax.vmap(varied, (None, *axes))
    wanted = jax.jit(jax.vmap(within, (0, *[None] * len(given))))(errors, *given)
    got = lanes.vmap(plain, axes)(*given)
    found: list[str] = []
    for number, (ours, theirs) in enumerate(zip(got, wanted, strict=True)):
        for place, (x, (y, doubt)) in enumerate(zip(ours, theirs, strict=True)):
            walkers = differing(np.asarray(x), np.asarray(y), np.asarray(doubt).any(0))
            if len(walkers):
                w = walkers[0]
                found.append(
                    f"program {number}, output {place}: walkers {walkers.tolist()} differ; "
                    f"walker {w} has {x[w]} instead of {np.asarray(y[0][w])}\n{programs[number]}"
                )
    return found


def differing(got: Any, wanted: Any, doubt: Any) -> Any:
    """Returns the walkers whose numbers differ by more than rounding explains.

    Args:
      wanted: [variant, walker, ...], the first without added errors.
    """
    exact, others = wanted[0], wanted[1:]
    assert (got.shape, got.dtype) == (exact.shape, exact.dtype), (got.dtype, exact.dtype)
    if np.issubdtype(got.dtype, np.floating):
        with np.errstate(all="ignore"):
            spread = np.abs(others.astype(np.float64) - exact).max(0)
            limit = 3 * spread + 4 * np.finfo(got.dtype).eps * np.abs(exact.astype(np.float64))
            limit = limit + 16 * float(np.finfo(got.dtype).tiny)
            alike = (got == exact) | (np.isnan(got) & np.isnan(exact))
            alike |= np.abs(got.astype(np.float64) - exact) <= limit
            same_kind = (np.isnan(others) == np.isnan(exact)).all(0)
            same_kind &= (np.isinf(others) == np.isinf(exact)).all(0)
            alike |= ~same_kind  # on the edge of overflow, or of what a function takes
    else:
        alike = (got == exact) | (others != exact).any(0)
    bad = ~alike.reshape(len(alike), -1).all(1) & ~doubt
    return np.flatnonzero(bad)
