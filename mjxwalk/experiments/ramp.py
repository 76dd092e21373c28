"""Ground that gets rougher as walkers get better."""

import dataclasses

from mjxwalk.envs.checks import not_negative, positive


@dataclasses.dataclass(frozen=True, kw_only=True)
class RoughnessRamp:
    """A line from one roughness to that of the environment's own terrain.

    Attributes:
      start: roughness in generation 1, m.
      generations: that the environment's own roughness is reached in.
    """

    start: float
    generations: int

    def __post_init__(self) -> None:
        not_negative(self, "start")
        positive(self, "generations")

    def at(self, generation: int, end: float) -> float:
        """Returns the roughness of a generation, m.

        Args:
          generation: counted from 1.
          end: roughness of the environment's own terrain, m.
        """
        if generation >= self.generations:
            return end
        return self.start + (end - self.start) * (generation - 1) / (self.generations - 1)
