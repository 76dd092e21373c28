"""What a walker is worth: weighted terms, so that a task needs no code."""

import dataclasses
from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from mjxwalk.envs import checks
from mjxwalk.envs.anatomy import Root
from mjxwalk.envs.state import State

# Terms that count against a walker, and what each counts.
COSTS = {
    "tracking": "how far the speed is from what is wanted",
    "drift": "the way sideways",
    "work": "the work of the motors",
    "torque": "the torque of the motors",
    "upright": "how far the torso tilts",
    "heading": "how far the torso turns away",
    "symmetry": "how much longer one foot stands than another",
    "action_rate": "how far what is asked of the motors moves",
}


class Seen(NamedTuple):
    """What a step shows that terms count.

    Attributes:
      senses: a `BodyObservation` of the state before the step.
      asked: of each motor, from -1 to 1.
      clear: height of each foot's origin over that at the start, over the ground below it, m.
      forbidden: whether a body touches the ground that must not.
    """

    senses: Any
    asked: Float[Array, " motor"]
    clear: Float[Array, " leg"] | None
    forbidden: Bool[Array, ""] | None


class Tally(NamedTuple):
    """What terms and ends have counted in a trial; None of those that nothing asks for.

    Attributes:
      tilt: integral of one less the vertical part of the torso's axis, s.
      heading: integral of how far the torso is turned from x, rad s.
      off_speed: integral of how far the speed is from that wanted, over it, s.
      clear: integral of how high feet in the air are, over the wanted height, s.
      standing: how long each foot has touched the ground, s.
      action_rate: how far what was asked has moved in all, over all motors.
      asked: of each motor last.
      forbidden: whether a body has touched the ground that must not.
    """

    tilt: Float[Array, ""] | None = None
    heading: Float[Array, ""] | None = None
    off_speed: Float[Array, ""] | None = None
    clear: Float[Array, ""] | None = None
    standing: Float[Array, " leg"] | None = None
    action_rate: Float[Array, ""] | None = None
    asked: Float[Array, " motor"] | None = None
    forbidden: Bool[Array, ""] | None = None


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
      upright: of a second with the torso on its side; one less the cosine of its tilt counts.
      heading: of a second turned by a radian.
      clearance: of a second with a foot in the air at `clear_height`; higher counts no more.
      clear_height: of a foot in the air, that is wanted, m.
      symmetry: of a second that one foot has stood longer than another.
      action_rate: of a motor's number moving by 1.
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
    clearance: float = 0.0
    clear_height: float = 0.05
    symmetry: float = 0.0
    action_rate: float = 0.0

    def __post_init__(self) -> None:
        checks.not_negative(self, "speed")
        checks.positive(self, "clear_height")
        checks.finite(self, *[field.name for field in dataclasses.fields(self)])
        for name, meaning in COSTS.items():
            if getattr(self, name) > 0.0:
                raise ValueError(
                    f"{name} must be 0 or negative, as it counts {meaning}, got "
                    f"{getattr(self, name):g}"
                )
        if self.tracking and not self.speed:
            raise ValueError("tracking needs a speed above 0 to track, got speed 0")

    def weights(self) -> dict[str, float]:
        """Returns the weight of each term by its name."""
        wanted = ("speed", "clear_height")  # what terms refer to, and no weights
        names = [field.name for field in dataclasses.fields(self)]
        return {name: getattr(self, name) for name in names if name not in wanted}

    def begin(self, *, legs: int, motors: int, watches: bool) -> Tally:
        """Returns what is counted at the start of a trial.

        Args:
          legs: of the body.
          motors: of the body.
          watches: whether some bodies must not touch the ground.
        """
        zero = jnp.zeros(())
        return Tally(
            tilt=zero if self.upright else None,
            heading=zero if self.heading else None,
            off_speed=zero if self.tracking else None,
            clear=zero if self.clearance else None,
            standing=jnp.zeros(legs) if self.symmetry else None,
            action_rate=zero if self.action_rate else None,
            asked=jnp.zeros(motors) if self.action_rate else None,
            forbidden=jnp.zeros((), bool) if watches else None,
        )

    def count(self, tally: Tally, seen: Seen, *, seconds: float) -> Tally:
        """Returns the tally after a step of so many seconds."""
        senses = seen.senses
        if tally.tilt is not None:
            tally = tally._replace(tilt=tally.tilt + seconds * (1.0 - senses.up[-1]))
        if tally.heading is not None:
            turned = jnp.sum(jnp.abs(senses.heading))
            tally = tally._replace(heading=tally.heading + seconds * turned)
        if tally.off_speed is not None:
            off = jnp.abs(senses.velocity[0] / self.speed - 1.0)
            tally = tally._replace(off_speed=tally.off_speed + seconds * off)
        if tally.clear is not None and seen.clear is not None:
            lifted = jnp.clip(seen.clear / self.clear_height, 0.0, 1.0)
            lifted = jnp.sum(jnp.where(senses.contact, 0.0, lifted))
            tally = tally._replace(clear=tally.clear + seconds * lifted)
        if tally.standing is not None:
            tally = tally._replace(standing=tally.standing + seconds * senses.contact)
        if tally.action_rate is not None and tally.asked is not None:
            moved = jnp.sum(jnp.abs(seen.asked - tally.asked))
            tally = tally._replace(action_rate=tally.action_rate + moved, asked=seen.asked)
        if tally.forbidden is not None and seen.forbidden is not None:
            tally = tally._replace(forbidden=tally.forbidden | seen.forbidden)
        return tally

    def total(self, state: State, root: Root, *, usual: float, timestep: float) -> Float[Array, ""]:
        """Returns what all terms come to at the end of a trial.

        Args:
          state: of the walker.
          root: of its body.
          usual: its weight times its height, N m.
          timestep: of the physics, s.
        """
        trial = state.trial
        seconds = trial.num_steps * timestep
        far = state.qpos[root.forward]
        if self.speed:
            far = jnp.minimum(far, self.speed * seconds)
        total = self.distance * far + self.alive * seconds
        if root.sideways is not None:
            total += self.drift * jnp.abs(state.qpos[root.sideways])
        total += self.work * trial.work / usual + self.torque * trial.torque_cost / usual
        return total + self.worth(state.own.tally)

    def worth(self, tally: Tally) -> Float[Array, ""]:
        """Returns what was counted comes to."""
        uneven = None if tally.standing is None else jnp.ptp(tally.standing)
        counted = (
            (self.upright, tally.tilt),
            (self.heading, tally.heading),
            (self.tracking, tally.off_speed),
            (self.clearance, tally.clear),
            (self.symmetry, uneven),
            (self.action_rate, tally.action_rate),
        )
        worth = jnp.zeros(())
        for weight, value in counted:
            if value is not None:
                worth += weight * value
        return worth
