"""What engines are measured on: walkers that all take the same number of steps."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Int


class Walked(NamedTuple):
    """A walker after its steps; all of its state is returned, so that no work can be left out."""

    walk: Any
    steps: Int[Array, "*batch"]


class Workload(NamedTuple):
    """A population, and what one walker does.

    Attributes:
      start: from genotype and trial to the walker at the start.
      advance: from genotype, trial and walker to the walker a step of control later.
      genotypes: leaves [pop, ...].
      given: their trials.
      axes: which axis of genotypes and trials counts walkers.
      substeps: steps of the physics in a step of control.
    """

    start: Callable[..., Any]
    advance: Callable[..., Any]
    genotypes: Any
    given: Any
    axes: Any
    substeps: int = 1


def fixed_steps(
    start: Callable[..., Any],
    advance: Callable[..., Any],
    genotype: Any,
    given: Any,
    num_steps: Int[Array, ""],
) -> Walked:
    """Returns one walker after so many steps of control, whether it fell on the way or not."""

    def unfinished(walked: Walked) -> Any:
        return walked.steps < num_steps

    def step(walked: Walked) -> Walked:
        return Walked(advance(genotype, given, walked.walk), walked.steps + 1)

    first = Walked(start(genotype, given), jnp.zeros((), jnp.int32))
    return jax.lax.while_loop(unfinished, step, first)
