"""A payload: what a body carries on its torso in a trial.

ours: the studies that this package follows have none, but for the body of Reil & Massey.
"""

import dataclasses

from jaxtyping import Array, Float

from mjxwalk.envs import checks


@dataclasses.dataclass(frozen=True, kw_only=True)
class Payload:
    """A point mass that is fixed to the torso; by default, none.

    Attributes:
      share: of the body's mass that the payload weighs; 0 is none.
      spread: largest deviation from it that a trial draws, to either side.
      forward: from the torso's own centre of mass, along the torso's x, m.
      left: from there along its y, m.
      up: from there along its z, m.
    """

    share: float = 0.0
    spread: float = 0.0
    forward: float = 0.0
    left: float = 0.0
    up: float = 0.0

    def __post_init__(self) -> None:
        checks.not_negative(self, "share", "spread")
        checks.finite(self, "forward", "left", "up")
        if self.spread > self.share:
            raise ValueError(
                f"spread of a payload must be its share, {self.share}, at most, as nothing weighs "
                f"less than nothing, got {self.spread}"
            )

    def __bool__(self) -> bool:
        return bool(self.share)

    def words(self) -> str:
        """Returns what is carried in a few words, "" where nothing is."""
        return f"{checks.span(100 * self.share, 100 * self.spread)} % of its mass" if self else ""

    @property
    def offset(self) -> tuple[float, float, float]:
        """From the torso's own centre of mass in its axes, m."""
        return self.forward, self.left, self.up

    def mass(self, load: Float[Array, ""], body: float) -> Float[Array, ""]:
        """Returns the mass of a draw from -1 to 1, kg.

        Args:
          load: the draw.
          body: mass of the body without its payload, kg.
        """
        return body * (self.share + self.spread * load)
