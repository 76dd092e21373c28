"""The fittest of each of the last generations, among whom a tournament seeks the winner."""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float, Int

NUM_ELITES = 50  # Solomon et al. (2013): the winner is sought among as many last generations' best


class Elites(NamedTuple):
    """The fittest of each of the last generations, newest last.

    Attributes:
      genotypes: leaves [elite, ...].
      fitness: in their own generation; NaN in a place not taken yet.
      generation: 0 in a place not taken yet.
    """

    genotypes: Any
    fitness: Float[np.ndarray, " elite"]
    generation: Int[np.ndarray, " elite"]

    @classmethod
    def none(cls, template: Any) -> "Elites":
        """Returns places for genotypes like the template, none of them taken."""
        return cls(
            genotypes=jax.tree.map(lambda leaf: np.stack([leaf] * NUM_ELITES), template),
            fitness=np.full(NUM_ELITES, np.nan, np.float32),
            generation=np.zeros(NUM_ELITES, np.int32),
        )

    def push(self, genotype: Any, fitness: Any, generation: int) -> "Elites":
        """Returns these without the oldest and with the elite of one more generation."""

        def shift(old: Any, new: Any) -> Any:
            return np.concatenate([old[1:], np.asarray(new, old.dtype)[None]])

        return Elites(
            genotypes=jax.tree.map(shift, self.genotypes, genotype),
            fitness=shift(self.fitness, fitness),
            generation=shift(self.generation, generation),
        )


def fittest(fitness: Float[np.ndarray, " pop"]) -> int:
    """Returns the place of the highest fitness; NaN is lower than any."""
    return int(np.argmax(np.where(np.isnan(fitness), -np.inf, fitness)))
