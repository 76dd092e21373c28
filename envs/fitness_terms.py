"""What a walker is worth: weighted terms, so that a task needs no code."""

import dataclasses
from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.envs import checks


class Tally(NamedTuple):
    """What terms count in a trial; None of those that have no weight.

    Attributes:
      tilt: integral of one less the vertical part of the torso's axis, s.
      heading: integral of how far the torso is turned from x, rad s.
      off_speed: integral of how far the speed is from that wanted, over it, s.
      action_rate: how far targets or torques have moved in all, of their range, summed over motors.
      action: that was asked for last.
    """

    tilt: Float[Array, ""] | None
    heading: Float[Array, ""] | None
    off_speed: Float[Array, ""] | None
    action_rate: Float[Array, ""] | None
    action: Float[Array, " motor"] | None


@dataclasses.dataclass(frozen=True, kw_only=True)
class FitnessTerms:
    """Weights of what counts for a walker and, negative, against it.

    Attributes:
      distance: of a metre forward, up to `speed` times the time.
      alive: of a second.
      speed: forward, that is wanted, m/s; 0 for as fast as it can.
      tracking: of a second at a speed that is off by all of `speed`.
      drift: of a metre sideways at the end.
      work: of the joints' work, of a weight lifted as high as the root stands.
      torque: of the motors' torque times time, of a weight times the root's height for a second.
      upright: of a second with the torso level.
      heading: of a second turned by a radian.
      action_rate: of the action moving by its range, over all motors.
    """

    distance: float = 0.5
    alive: float = 1.0
    speed: float = 0.8
    tracking: float = 0.0
    drift: float = -0.3
    work: float = -0.1
    torque: float = 0.0
    upright: float = 0.0
    heading: float = 0.0
    action_rate: float = 0.0

    def __post_init__(self) -> None:
        checks.not_negative(self, "speed")
        names = [field.name for field in dataclasses.fields(self)]
        checks.finite(self, *names)

    def begin(self, num_motors: int) -> Tally:
        """Returns what is counted at the start of a trial."""
        zero = jnp.zeros(())
        return Tally(
            tilt=zero if self.upright else None,
            heading=zero if self.heading else None,
            off_speed=zero if self.tracking else None,
            action_rate=zero if self.action_rate else None,
            action=jnp.zeros(num_motors) if self.action_rate else None,
        )

    def count(self, tally: Tally, seen: Any, action: Any, *, seconds: float) -> Tally:
        """Returns the tally after a step.

        Args:
          tally: before it.
          seen: a `BodyObservation` of the state before.
          action: numbers from -1 to 1, one for each motor.
          seconds: that the step took.
        """
        if tally.tilt is not None:
            tally = tally._replace(tilt=tally.tilt + seconds * (1.0 - seen.up[-1]))
        if tally.heading is not None:
            turned = jnp.sum(jnp.abs(seen.heading))
            tally = tally._replace(heading=tally.heading + seconds * turned)
        if tally.off_speed is not None:
            off = jnp.abs(seen.velocity[0] / max(self.speed, 1e-6) - 1.0)
            tally = tally._replace(off_speed=tally.off_speed + seconds * off)
        if tally.action_rate is not None:
            moved = jnp.sum(jnp.abs(action - tally.action))
            tally = tally._replace(action_rate=tally.action_rate + moved, action=action)
        return tally
