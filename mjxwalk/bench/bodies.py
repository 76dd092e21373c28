"""What is simulated: bodies by name, and walkers that all take the same number of steps."""

import functools
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int

from mjxwalk import experiments, rollout
from mjxwalk.envs import Terrain
from mjxwalk.experiments.experiment import Experiment

# The name of a body in the results, and the experiment that has its body and its controller.
BODIES: Mapping[str, str] = {"planar": "planar-lpd"}
TRIAL_AXES: Any = (0, Terrain(None, 0))  # type: ignore[arg-type]
FIXED_AXES: Any = (*TRIAL_AXES, None)
WEIGHT_SIGMA = 0.3  # ours: as wide as the experiment's first generation
SAME_WORK = (
    "same work: every walker takes the same number of steps; the rules of a trial are computed "
    "but end nobody"
)


class Walked(NamedTuple):
    """A walker after its steps; all of its state is returned, so that no work can be left out."""

    walk: Any
    steps: Int[Array, "*batch"]


class Walkers(NamedTuple):
    """A population, and what one of them does.

    Attributes:
      start: from genotype and terrain to the walker at the start.
      advance: from genotype, terrain and walker to the walker a step later.
      genotypes: leaves [pop, ...].
      terrain: that they walk on.
    """

    start: Callable[..., Any]
    advance: Callable[..., Any]
    genotypes: Any
    terrain: Any


def experiment(body: str) -> Experiment:
    """Returns the experiment that has a body."""
    return experiments.get(BODIES[body])


def walkers(study: Experiment, size: int) -> Walkers:
    """Returns walkers with weights drawn at random, all on one terrain."""
    draws = np.random.default_rng(0)

    def drawn(leaf: Any) -> Any:
        return draws.normal(0.0, WEIGHT_SIGMA, (size, *leaf.shape)).astype(np.float32)

    heights = np.asarray(study.sample_terrains(jax.random.key(0), 1, 0))
    rows: Any = np.zeros(size, np.int32)
    terrain: Any = Terrain(heights, rows)  # type: ignore[arg-type]
    return Walkers(
        start=functools.partial(rollout.start, study.env, study.controller),
        advance=functools.partial(rollout.advance, study.env, study.controller),
        genotypes=jax.tree.map(drawn, study.template()),
        terrain=terrain,
    )


def fixed_steps(
    start: Callable[..., Any],
    advance: Callable[..., Any],
    genotype: Any,
    terrain: Any,
    num_steps: Int[Array, ""],
) -> Walked:
    """Returns one walker after that many steps, whether it fell on the way or not."""

    def unfinished(walked: Walked) -> Any:
        return walked.steps < num_steps

    def step(walked: Walked) -> Walked:
        return Walked(advance(genotype, terrain, walked.walk), walked.steps + 1)

    first = Walked(start(genotype, terrain), jnp.zeros((), jnp.int32))
    return jax.lax.while_loop(unfinished, step, first)
