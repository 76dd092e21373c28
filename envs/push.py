"""Pushes: short forces on the torso that trials draw.

ours: the studies that this package follows have none. A push is told by the change of speed that it
gives to the whole body, so that one setting is as much for a light body as for a heavy one.
"""

import dataclasses
from typing import Literal

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk.envs import checks

MOST = 100  # of one trial; ours: each is looked at in every step
DIRECTIONS = "any", "forward", "sideways"
BEGIN, CHANGE = 0, slice(1, 3)  # columns of a trial's pushes


@dataclasses.dataclass(frozen=True, kw_only=True)
class Push:
    """Forces on the torso's centre of mass, one in each period; by default, none.

    Attributes:
      speed: by which a push changes that of the whole body, without payload, m/s; 0 is none. A
        negative one pushes backwards.
      spread: largest deviation from it that a push draws, to either side, m/s.
      duration: of each push, s; its force is constant.
      number: of periods, and so of pushes.
      begin: of the first period, s.
      every: length of a period, s; when in it the push begins is drawn.
      direction: "forward" is along x, "sideways" to the left or right as drawn, "any" one of all
        level directions; a body in the plane feels the part along x.
    """

    speed: float = 0.0
    spread: float = 0.0
    duration: float = 0.1
    number: int = 1
    begin: float = 2.0
    every: float = 3.0
    direction: Literal["any", "forward", "sideways"] = "any"

    def __post_init__(self) -> None:
        checks.finite(self, "speed")
        checks.not_negative(self, "spread", "begin")
        checks.positive(self, "duration", "every")
        checks.count(self, "number")
        if self.number > MOST:
            raise ValueError(f"number of pushes must be at most {MOST}, got {self.number:,}")
        if self.every < self.duration:
            raise ValueError(
                f"every must be the duration of a push at least, {self.duration} s, got "
                f"{self.every} s"
            )
        if self.direction not in DIRECTIONS:
            raise ValueError(
                f'direction must be "any", "forward" or "sideways", got "{self.direction}"'
            )

    def __bool__(self) -> bool:
        return bool(self.speed or self.spread)

    def words(self) -> str:
        """Returns what pushes there are in a few words, "" where there are none."""
        if not self:
            return ""
        way = "in any direction" if self.direction == "any" else self.direction
        return f"{self.number} of {checks.span(self.speed, self.spread)} m/s {way}"

    def sample(self, key: PRNGKeyArray, num: int) -> Float[Array, "trial push 3"] | None:
        """Returns the pushes of `num` trials; None where there are none.

        Returns:
          When each begins, s, and by what it changes the body's velocity along x and y, m/s.
        """
        if not self:
            return None
        shape = num, self.number
        key_begin, key_speed, key_direction = jax.random.split(key, 3)
        periods = self.begin + self.every * np.arange(self.number, dtype=np.float32)
        late = (self.every - self.duration) * jax.random.uniform(key_begin, shape)
        draws = jax.random.uniform(key_speed, shape, minval=-1.0, maxval=1.0)
        along = self._directions(key_direction, shape)
        change = (self.speed + self.spread * draws)[..., None] * along
        return jnp.concatenate([(periods + late)[..., None], change], axis=-1)

    def acceleration(
        self, pushes: Float[Array, "push 3"], steps: Int[Array, ""], timestep: float
    ) -> Float[Array, "2"]:
        """Returns what pushes give to the whole body along x and y, m/s^2.

        It is the average over a step, so that a push gives the same whatever the step.

        Args:
          pushes: of one trial.
          steps: that the trial has had.
          timestep: s.
        """
        # One step's end is the next one's start to the last bit, and so all shares add up.
        start, end = (
            jnp.clip(count * timestep - pushes[:, BEGIN], 0.0, self.duration)
            for count in (steps, steps + 1)
        )
        share = (end - start) / (self.duration * timestep)
        return share @ pushes[:, CHANGE]

    def _directions(
        self, key: PRNGKeyArray, shape: tuple[int, int]
    ) -> Float[Array, "trial push 2"]:
        """Returns unit vectors, as drawn."""
        if self.direction == "any":
            angle = jax.random.uniform(key, shape, maxval=2.0 * np.pi)
            return jnp.stack([jnp.cos(angle), jnp.sin(angle)], axis=-1)
        if self.direction == "sideways":
            side = jax.random.rademacher(key, shape, jnp.float32)
            return jnp.stack([jnp.zeros(shape), side], axis=-1)
        return jnp.stack([jnp.ones(shape), jnp.zeros(shape)], axis=-1)
