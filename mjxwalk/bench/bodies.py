"""What is simulated: bodies by name, and walkers that all take the same number of steps."""

import functools
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int

from mjxwalk import experiments, rollout
from mjxwalk.envs import TRIAL_AXES, Trials

WEIGHT_SIGMA = 0.3  # ours: as wide as the experiment's first generation
SAME_WORK = (
    "same work: every walker takes the same number of steps; the rules of a trial are computed "
    "but end nobody"
)


class Body(NamedTuple):
    """A body to measure with.

    Attributes:
      study: makes the experiment with the body and its controller.
      controller: in words.
      slow: whether XLA compiles it for so long that a quick bench has to leave mjx out.
    """

    study: Callable[[], Any]
    controller: str
    slow: bool = False


BODIES: Mapping[str, Body] = {  # by the name in the results
    "planar": Body(
        functools.partial(experiments.get, "planar-lpd"),
        "linear reactive control of planar-lpd, weights at random",
    ),
    "spatial": Body(
        functools.partial(experiments.get, "solomon-3d"),
        "linear reactive control of solomon-3d, weights at random; ground of r = 0.002 m",
        slow=True,
    ),
}


class Walked(NamedTuple):
    """A walker after its steps; all of its state is returned, so that no work can be left out."""

    walk: Any
    steps: Int[Array, "*batch"]


class Workload(NamedTuple):
    """What engines are measured on: a population, and what one walker does.

    Attributes:
      start: from genotype and trial to the walker at the start.
      advance: from genotype, trial and walker to the walker a step later.
      genotypes: leaves [pop, ...].
      given: their trials.
    """

    start: Callable[..., Any]
    advance: Callable[..., Any]
    genotypes: Any
    given: Any

    @property
    def axes(self) -> Any:
        """Which axis of genotypes and trials counts walkers: they share the heights."""
        return 0, TRIAL_AXES


def workload(body: Body, size: int) -> Workload:
    """Returns walkers with weights drawn at random, all on one terrain."""
    study = body.study()
    draws = np.random.default_rng(0)

    def drawn(leaf: Any) -> Any:
        return draws.normal(0.0, WEIGHT_SIGMA, (size, *leaf.shape)).astype(np.float32)

    return Workload(
        start=functools.partial(rollout.start, study.env, study.controller),
        advance=functools.partial(rollout.advance, study.env, study.controller),
        genotypes=jax.tree.map(drawn, study.template()),
        given=_trials(body).given(np.zeros(size, np.int32)),
    )


@functools.cache
def _trials(body: Body) -> Trials:
    """Returns one trial; kept, as in a quick bench making it would be felt each time."""
    return jax.tree.map(np.asarray, body.study().sample_trials(jax.random.key(0), 1))


def fixed_steps(
    start: Callable[..., Any],
    advance: Callable[..., Any],
    genotype: Any,
    given: Any,
    num_steps: Int[Array, ""],
) -> Walked:
    """Returns one walker after that many steps, whether it fell on the way or not."""

    def unfinished(walked: Walked) -> Any:
        return walked.steps < num_steps

    def step(walked: Walked) -> Walked:
        return Walked(advance(genotype, given, walked.walk), walked.steps + 1)

    first = Walked(start(genotype, given), jnp.zeros((), jnp.int32))
    return jax.lax.while_loop(unfinished, step, first)
