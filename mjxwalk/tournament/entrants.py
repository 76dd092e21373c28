"""The walkers that compete in a tournament."""

import dataclasses
from typing import Any

import numpy as np
from jaxtyping import Int


@dataclasses.dataclass(frozen=True, kw_only=True)
class Entrants:
    """The walkers that a source offers for comparison.

    Attributes:
      name: of the source, as text to show.
      experiment: that they evolved in.
      genotypes: leaves [walker, ...], newest last; numpy.
      generations: in which each was the fittest.
    """

    name: str
    experiment: Any
    genotypes: Any
    generations: Int[np.ndarray, " walker"]

    def __len__(self) -> int:
        return len(self.generations)

    def of_generation(self, generation: int) -> Any:
        """Returns the genotype of that generation's walker.

        Raises:
          ValueError: there is none.
        """
        places = np.flatnonzero(self.generations == generation)
        if not places.size:
            raise ValueError(f"{self.name} has no walker of generation {generation}")
        import jax

        return jax.tree.map(lambda leaf: leaf[places[-1]], self.genotypes)
