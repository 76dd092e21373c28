"""Figures of a generation, from what its walkers did on their terrains."""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from mjxwalk.outcomes import cost_of_transport, over_terrains, speed
from mjxwalk.rollout import Outcome
from mjxwalk.runs import Metrics
from mjxwalk.runs.metrics import NUM_EVALUATED
from mjxwalk.runs.trees import flatten


class MeanOutcome(NamedTuple):
    """What each genotype of a generation did: means over its terrains, units as in `Outcome`."""

    distance: Float[np.ndarray, " pop"]
    duration: Float[np.ndarray, " pop"]
    fell: Float[np.ndarray, " pop"]
    diverged: Float[np.ndarray, " pop"]
    torque_cost: Float[np.ndarray, " pop"]
    work: Float[np.ndarray, " pop"]
    steps: Float[np.ndarray, " pop"]


def summarise(outcome: Outcome) -> MeanOutcome:
    """Returns means over the terrains of outcomes [pop, terrain]."""
    return MeanOutcome(*[over_terrains(getattr(outcome, field)) for field in MeanOutcome._fields])


def measure(
    outcome: Outcome,
    best: int,
    *,
    generation: int,
    weight: float,
    told: Any,
    evaluate_s: float,
    compile_s: float,
    other_s: float,
    num_evaluated: int | None = None,
) -> Metrics:
    """Returns a generation's line of figures.

    Args:
      outcome: numpy arrays [pop, terrain].
      best: place of the fittest genotype.
      generation: counted from 1.
      weight: of the body, N.
      told: the strategy's metrics, scalars in a pytree.
      evaluate_s: wall time of the trials.
      compile_s: wall time of compiling.
      other_s: wall time of the rest.
      num_evaluated: genotypes of a population that grows; None of one that is always as large.
    """
    fitness = over_terrains(outcome.fitness)
    distance = over_terrains(outcome.distance)
    steps = int(np.sum(outcome.steps, dtype=np.int64))
    size = {} if num_evaluated is None else {NUM_EVALUATED: float(num_evaluated)}
    return Metrics(
        generation=generation,
        best_fitness=_number(fitness[best]),
        mean_fitness=_finite(np.mean, fitness),
        median_fitness=_finite(np.median, fitness),
        best_distance_m=_number(distance[best]),
        mean_distance_m=_finite(np.mean, distance),
        median_distance_m=_finite(np.median, distance),
        fall_share=float(np.mean(outcome.fell)),
        diverged_share=float(np.mean(outcome.diverged)),
        speed_m_s=speed(outcome.distance[best], outcome.duration[best]),
        cost_of_transport=cost_of_transport(outcome.work[best], outcome.distance[best], weight),
        physics_steps=steps,
        steps_per_s=steps / max(evaluate_s, 1e-9),
        evaluate_s=evaluate_s,
        compile_s=compile_s,
        other_s=other_s,
        strategy=_scalars(told) | size,
    )


def _scalars(told: Any) -> dict[str, float | None]:
    named = flatten(jax.device_get(told))
    # The summary of fitness has its own names, whatever else a strategy tells.
    return {
        name.removeprefix("fitness."): _number(value)
        for name, value in named.items()
        if value.ndim == 0
    }


def _finite(average: Any, values: Float[np.ndarray, " pop"]) -> float | None:
    finite = values[np.isfinite(values)]
    return float(average(finite.astype(np.float64))) if finite.size else None


def _number(value: Any) -> float | None:
    return float(value) if np.isfinite(value) else None
