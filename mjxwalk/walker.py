"""One walker: what it evolved in, and its weights."""

import dataclasses
from typing import Any, Literal


@dataclasses.dataclass(frozen=True, kw_only=True)
class Walker:
    """One walker.

    Attributes:
      name: of its source, as text to show.
      rank: "winner" of a tournament, "champion" of a finished run, or only the "fittest" of the
        newest generation.
      experiment: that it evolved in.
      genotype: its weights; numpy.
      generation: in which it was the fittest.
    """

    name: str
    rank: Literal["winner", "champion", "fittest"]
    experiment: Any
    genotype: Any
    generation: int
