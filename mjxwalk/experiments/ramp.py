"""Ground whose roughness follows how well the walkers do."""

import dataclasses
from typing import Any

import numpy as np

from mjxwalk.envs.checks import not_negative, positive

GOOD_SHARE = 0.2  # ours: whose distance counts, the parents of Solomon et al. (2013), section 2.7.3


@dataclasses.dataclass(frozen=True, kw_only=True)
class RoughnessRamp:
    """A roughness that nears that of the environment's own terrain by steps that are earned.

    Attributes:
      start: roughness in generation 1, m; below the environment's own, or above it.
      factor: by which it nears that after a good generation.
      distance: that the farthest fifth of a good generation walk on average, m.
    """

    start: float = 0.001  # ours
    factor: float = 1.03
    distance: float = 0.0

    def __post_init__(self) -> None:
        positive(self, "start")
        not_negative(self, "distance")
        if not self.factor > 1:
            raise ValueError(f"factor must be above 1, got {self.factor}")

    def after(self, roughness: float, distance: Any, end: float) -> float:
        """Returns the roughness of the next generation, m.

        Args:
          roughness: of this one, m.
          distance: that its walkers came, m; NaN counts as nothing walked.
          end: roughness of the environment's own terrain, m.
        """
        walked = np.sort(np.nan_to_num(np.asarray(distance, np.float64), nan=0.0))
        good = walked[-max(1, round(GOOD_SHARE * walked.size)) :]
        if good.mean() < self.distance:
            return roughness
        if roughness < end:
            return min(end, roughness * self.factor)
        return max(end, roughness / self.factor)
