"""Tries a walker on the same terrains by an engine and by C MuJoCo."""

import time
from collections.abc import Callable
from typing import Any

import jax
import numpy as np

from mjxwalk import evaluation
from mjxwalk.engines.pinning import pinned
from mjxwalk.fitting import Fitting
from mjxwalk.verify import agreement, supported, trials
from mjxwalk.verify.agreement import Agreement
from mjxwalk.walker import Walker

C_MUJOCO = "C MuJoCo"
# Folded into the seed's key, it leads away from the keys of runs, tournaments and analyses.
VERIFY = 0x76657269


@pinned()
def verify(
    walker: Walker,
    *,
    engine: str,
    terrains: int,
    seed: int,
    roughness: float | None = None,
    say: Callable[[str], None],
) -> Agreement:
    """Returns how an engine and C MuJoCo agree on a walker.

    Args:
      walker: to try.
      engine: as `mjxwalk.engines.choose` knows it.
      terrains: number of them.
      seed: of the terrains.
      roughness: step of the random terrain, m; None for that which its last generation met.
      say: is told what goes on.

    Raises:
      ValueError: there is no such engine, or the body has what we have no law for.
    """
    _check(walker)
    experiment = walker.experiment.as_tested()
    key = jax.random.fold_in(jax.random.key(seed), VERIFY)
    given = experiment.sample_trials(key, terrains, roughness)
    evaluator = evaluation.make_evaluator(experiment, engine)
    say(f"{walker.name}, generation {walker.generation}, on {terrains} terrains by engine {engine}")
    alone: Any = jax.tree.map(lambda leaf: np.asarray(leaf)[None], walker.genotype)
    outcome = jax.tree.map(lambda leaf: leaf[0], evaluator.evaluate(alone, given))
    say(f"the same in {C_MUJOCO}, float64")
    started = time.perf_counter()
    reference = trials.run(experiment.env, experiment.controller, walker.genotype, given)
    say(f"walked {reference.duration.sum():.0f} s in {time.perf_counter() - started:.0f} s")
    return agreement.compare(
        agreement.side(evaluator.engine, outcome, experiment.weight),
        agreement.side(C_MUJOCO, reference, experiment.weight),
        walker=walker.name,
        generation=walker.generation,
        seed=seed,
        roughness_m=experiment.env.terrain.roughness if roughness is None else roughness,
    )


def _check(walker: Walker) -> None:
    if isinstance(walker.experiment, Fitting):
        raise ValueError(f"{walker.name} is a fit, which walks nowhere; there is nothing to verify")
    supported.check(walker.name, getattr(walker.experiment, "env", None))
