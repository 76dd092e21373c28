"""Populations that grow within a generation, until their walkers have done enough steps.

Toklu, Liskowski & Srivastava (2020), "ClipUp: a simple and powerful optimizer for
distribution-based policy evolution", https://arxiv.org/abs/2008.02387; `num_interactions` of
nnaisense/pgpelib.

The strategy is asked for all genotypes that there can be. What it is told are those that were
evaluated, as the strategy of so small a population: its state does not depend on how many they are.
"""

import dataclasses
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float, Int

from mjxwalk.experiments.goal import take
from mjxwalk.experiments.growth import Growth
from mjxwalk.rollout import Outcome, TrialRunner
from mjxwalk.strategies import Strategy


class Evaluated(NamedTuple):
    """What a generation has evaluated of the genotypes that it could have.

    Attributes:
      places: of those genotypes, ascending.
      genotypes: leaves [evaluated, ...].
      outcome: of each, numpy arrays [evaluated, trial].
    """

    places: Int[np.ndarray, " evaluated"] | slice
    genotypes: Any
    outcome: Outcome


def of(experiment: Any) -> Growth | None:
    """Returns how the populations of an experiment grow, None if they do not."""
    return getattr(experiment, "growth", None)


def strategy_of(experiment: Any, size: int) -> Strategy[Any, Any]:
    """Returns an experiment's strategy with a population of another size."""
    return dataclasses.replace(experiment, population_size=size).make_strategy()


def evaluate(
    growth: Growth | None, evaluator: TrialRunner, population: Any, trials: Any
) -> Evaluated:
    """Returns what was evaluated: all, or parts until they have done enough steps.

    Args:
      growth: how the population grows; None to evaluate all of it.
      evaluator: tries the genotypes.
      population: all genotypes that there can be, leaves [pop, ...]; the noise of the second half
        is that of the first, negated.
      trials: that each genotype is given.
    """
    if growth is None:
        return Evaluated(slice(None), population, evaluator.evaluate(population, trials))
    middle, pairs = size_of(population) // 2, growth.part // 2
    parts: list[Outcome] = []
    steps = 0
    while steps < growth.interactions and len(parts) * pairs < middle:
        places = _pairs(len(parts) * pairs, pairs, middle)
        parts.append(evaluator.evaluate(take(population, places), trials))
        steps += int(np.sum(parts[-1].steps, dtype=np.int64))
    places = _pairs(0, len(parts) * pairs, middle)
    return Evaluated(places, take(population, places), _joined(parts, pairs))


def like_a_part(growth: Growth | None, population: Any) -> Any:
    """Returns as many genotypes as are evaluated at a time."""
    if growth is None:
        return population
    return jax.tree.map(lambda leaf: leaf[: growth.part], population)


def spread(values: Any, evaluated: Evaluated, size: int) -> Float[np.ndarray, " pop"]:
    """Returns values of what was evaluated as values of so many genotypes, NaN of the others."""
    whole = np.full(size, np.nan, np.float32)
    whole[evaluated.places] = values
    return whole


def size_of(population: Any) -> int:
    """Returns the number of genotypes."""
    return jax.tree.leaves(population)[0].shape[0]


def _pairs(first: int, num: int, middle: int) -> Int[np.ndarray, " place"]:
    """Returns the places of so many pairs from the first on."""
    half = first + np.arange(num)
    return np.concatenate([half, middle + half])


def _joined(parts: list[Outcome], pairs: int) -> Outcome:
    """Returns the outcomes of all parts: of all first halves, and then of all second halves."""

    def join(*leaves: Any) -> Any:
        return np.concatenate([leaf[:pairs] for leaf in leaves] + [leaf[pairs:] for leaf in leaves])

    return jax.tree.map(join, *parts)
