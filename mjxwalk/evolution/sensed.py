"""What populations have sensed since the start of a run: the evolution adds it up here.

Sums come back from each trial of each genotype and are added in the order of the population, in
double precision, so that neither the engine's threads nor the number of processes changes a bit.
"""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from mjxwalk.controllers.normalisation import Normalised, Statistics, Sums


class Sensed(NamedTuple):
    """Readings of the senses, in double precision.

    Attributes:
      num: how many.
      mean: of each sense.
      squares: sum of squared differences from the mean.
    """

    num: Float[np.ndarray, ""]
    mean: Float[np.ndarray, " input"]
    squares: Float[np.ndarray, " input"]

    @property
    def statistics(self) -> Statistics:
        """As genotypes carry them."""
        variance = self.squares / np.maximum(self.num, 1.0)
        of = (self.num, self.mean, np.sqrt(variance))
        return Statistics._make(np.asarray(leaf, np.float32) for leaf in of)

    def add(self, sums: Sums) -> "Sensed":
        """Returns the readings with those of a generation: sums [pop, trial, ...].

        They are less the mean that the population's genotypes carry, which is that of this.
        Trials in which the physics diverged count as far as their sums are finite.
        """
        sound = np.isfinite(sums.total).all(-1) & np.isfinite(sums.squares).all(-1)
        num, total, squares = (np.sum(np.asarray(part, np.float64)[sound], axis=0) for part in sums)
        if not num:
            return self
        before = np.asarray(self.statistics.mean, np.float64)
        away = total / num
        within = np.maximum(squares - num * away**2, 0.0)
        gap = before + away - self.mean
        share = num / (self.num + num)
        return Sensed(
            num=self.num + num,
            mean=self.mean + share * gap,
            squares=self.squares + within + self.num * share * gap**2,
        )


def begin(template: Any) -> Sensed | None:
    """Returns what is sensed before the first generation: what a template carries, mostly nothing.

    None of a controller that does not normalise its senses.
    """
    if not isinstance(template, Normalised):
        return None
    num, mean, deviation = (np.asarray(leaf, np.float64) for leaf in template.senses)
    return Sensed(num, mean, num * deviation**2)


def put(population: Any, sensed: Sensed | None) -> Any:
    """Returns a population whose genotypes carry what was sensed, leaves [pop, ...]."""
    if sensed is None:
        return population
    size = jax.tree.leaves(population.weights)[0].shape[0]
    senses = jax.tree.map(lambda leaf: np.stack([leaf] * size), sensed.statistics)
    return population._replace(senses=senses)
