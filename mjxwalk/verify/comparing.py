"""Tries a walker on the same terrains by an engine and by C MuJoCo."""

import time
from collections.abc import Callable
from typing import Any

import jax
import numpy as np

from mjxwalk import evaluation
from mjxwalk.engines.pinning import pinned
from mjxwalk.experiments import walk
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
    contact: str | None = None,
    say: Callable[[str], None],
) -> Agreement:
    """Returns how an engine and C MuJoCo agree on a walker.

    Args:
      walker: to try.
      engine: as `mjxwalk.engines.choose` knows it.
      terrains: number of them.
      seed: of the terrains.
      roughness: step of the random terrain, m; None for that which its last generation met.
      contact: law under which C MuJoCo walks; None for that which the walker evolved under.
      say: is told what goes on.

    Raises:
      ValueError: the body has not that law, or what we have no law for, or there is no such
        engine.
    """
    _check(walker)
    experiment = walker.experiment.as_tested()
    other = experiment if contact is None else _under(experiment, contact)
    key = jax.random.fold_in(jax.random.key(seed), VERIFY)
    given = experiment.sample_trials(key, terrains, roughness)
    evaluator = evaluation.make_evaluator(experiment, engine)
    say(f"{walker.name}, generation {walker.generation}, on {terrains} terrains by engine {engine}")
    alone: Any = jax.tree.map(lambda leaf: np.asarray(leaf)[None], walker.genotype)
    outcome = jax.tree.map(lambda leaf: leaf[0], evaluator.evaluate(alone, given))
    name = C_MUJOCO if other is experiment else f"{C_MUJOCO}, contact law {contact}"
    say(f"the same in {name}, float64")
    started = time.perf_counter()
    reference = trials.run(other.env, other.controller, walker.genotype, given)
    say(f"walked {reference.duration.sum():.0f} s in {time.perf_counter() - started:.0f} s")
    return agreement.compare(
        agreement.side(evaluator.engine, outcome, experiment.weight),
        agreement.side(name, reference, experiment.weight),
        walker=walker.name,
        generation=walker.generation,
        seed=seed,
        roughness_m=experiment.env.terrain.roughness if roughness is None else roughness,
    )


def _under(experiment: Any, contact: str) -> Any:
    """Returns the experiment under a contact law, itself where that is its own."""
    if getattr(experiment.env, "contact_law", None) == contact:
        return experiment
    return walk.with_contact(experiment, contact)


def _check(walker: Walker) -> None:
    if isinstance(walker.experiment, Fitting):
        raise ValueError(f"{walker.name} is a fit, which walks nowhere; there is nothing to verify")
    supported.check(walker.name, getattr(walker.experiment, "env", None))
