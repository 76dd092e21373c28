"""Motors that are force-limited velocity constraints, solved for at the end of the step.

Reil & Massey (2001), "Facilitating controller evolution in morpho-functional machines - a bipedal
case study", section 4.2: a joint is asked for a velocity that brings it to a desired angle, and the
constraint solver finds the torque that gives it, up to a limit. No gain has to be tuned, and as
the velocity is that after the step, no step is too long for the motor to be stable.
"""

import dataclasses

import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.envs import checks


@dataclasses.dataclass(frozen=True, kw_only=True)
class VelocityMotor:
    """How fast a motor approaches its desired angle, and how strong it is.

    Attributes:
      approach: share of what is missing to the desired angle that is requested a second, 1/s.
      max_speed: fastest request, rad/s.
      max_torque: N m.
      softness: how far a torque leaves the joint short of its request, rad/s/(N m), as solvers of
        constraints have it; 0 for a rigid constraint, else a viscous one.
    """

    approach: float
    max_speed: float
    max_torque: float
    softness: float = 0.0

    def __post_init__(self) -> None:
        checks.positive(self, "approach", "max_speed", "max_torque")
        checks.not_negative(self, "softness")

    def request(
        self, target: Float[Array, " motor"], angle: Float[Array, " motor"]
    ) -> Float[Array, " motor"]:
        """Returns the velocities that would bring joints to their desired angles, rad/s."""
        return jnp.clip(self.approach * (target - angle), -self.max_speed, self.max_speed)

    def torques(self, answer: Float[Array, "2 2"], wanted: Float[Array, "2"]) -> Float[Array, "2"]:
        """Returns the torques of two motors that bring their joints to the requests, N m.

        Args:
          answer: change of velocity over the step for each torque, rad/s/(N m).
          wanted: change of velocity from that without motors to the request, rad/s.
        """
        return limited_pair(answer + self.softness * jnp.eye(2), wanted, self.max_torque)


def limited_pair(
    matrix: Float[Array, "2 2"], wanted: Float[Array, "2"], limit: float | Float[Array, ""]
) -> Float[Array, "2"]:
    """Returns torques of two motors that give the wanted changes of velocity, up to a limit.

    A torque at the limit leaves its joint short of what was wanted, any other gives it exactly;
    that is the minimum of x A x / 2 - x b with every |x| up to the limit. Where the minimum without
    limits lies beyond just one of them, that limit holds and the other torque follows; where it
    lies beyond both, at least one of them holds. Exact, without a loop.

    Args:
      matrix: change of velocity for each torque, rad/s/(N m); symmetric, positive definite.
      wanted: change of velocity, rad/s.
      limit: of either torque's absolute value, N m.
    """
    (a, b), (_, d) = matrix
    first = jnp.clip((d * wanted[0] - b * wanted[1]) / (a * d - b * b), -limit, limit)
    second = jnp.clip((wanted[1] - b * first) / d, -limit, limit)
    first = jnp.clip((wanted[0] - b * second) / a, -limit, limit)
    return jnp.stack([first, second])
