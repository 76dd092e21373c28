"""Soft ground contact at points: spring, damper and Coulomb friction.

Solomon, Locascio & Hartmann (2013), "Linear reactive control for efficient 2D and 3D bipedal
walking over rough terrain", Adaptive Behavior 21(1), section 2.3. The tangential law follows its
source for contact, Haavisto & Hyotyniemi (2004): a spring anchored where the foot came down, which
slips where friction cannot hold it. In the plane there is one tangential direction; in space there
are two, and friction's limit is a cone.
"""

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from mjxwalk.envs import checks


class ContactForce(NamedTuple):
    """What the ground does to one point.

    Attributes:
      tangential: level force, N; a number in the plane, x and y in space.
      normal: upward force, N; level ground never pulls.
      added_mass: point mass that stands for the implicit part of the law, kg.
      stretch: tangential spring's stretch after slipping, m; zero in the air.
      touching: whether the point is below the ground.
    """

    tangential: Float[Array, "*plane"]
    normal: Float[Array, ""]
    added_mass: Float[Array, ""]
    stretch: Float[Array, "*plane"]
    touching: Bool[Array, ""]


class Footing(NamedTuple):
    """Other soil at a place: by what the law of contact is multiplied there.

    Attributes:
      stiffness: factor of spring and damper.
      friction: factor of the coefficient.
    """

    stiffness: Float[Array, ""]
    friction: Float[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class SoftContact:
    """Penalty contact with one law for the normal and, up to friction's limit, the tangent.

    Attributes:
      stiffness: N/m.
      damping: N s/m.
      friction: Coulomb coefficient.
    """

    stiffness: float = 50_000.0  # section 2.3
    damping: float = 2_500.0  # section 2.3
    friction: float = 1.0  # ours: equation 2 is lost; rubber on a dry floor

    def __post_init__(self) -> None:
        checks.positive(self, "stiffness")
        checks.not_negative(self, "damping", "friction")

    def force(
        self,
        depth: Float[Array, ""],
        velocity: tuple[Float[Array, "*plane"], Float[Array, ""]],
        stretch: Float[Array, "*plane"],
        *,
        timestep: float,
        implicit: bool,
        footing: Footing | None = None,
    ) -> ContactForce:
        """Returns the force on a point.

        Taken linearly implicit, the force at the end of the step is
        `k (depth - dt v') - d v'` with the still unknown velocity `v' = v + dt a`. Its known part
        is the same law with damping `d + k dt`; its unknown part, `-dt (d + k dt) a`, is the
        inertia of a point mass, which the caller adds to the body before solving for `a`. The mass
        resists along the tangent also where the point slips, an error of the order of the step.

        Args:
          depth: how far the point is below the ground, m.
          velocity: of the point, tangential (as in `ContactForce`) and upward, m/s.
          stretch: tangential spring's stretch at the end of the last step, m.
          timestep: s.
          implicit: whether spring and damper are taken at the end of the step.
          footing: other soil; None for that of this law.
        """
        stiffness, damping, friction = self._at(footing)
        damping = damping + (stiffness * timestep if implicit else 0.0)
        tangential_velocity, upward_velocity = velocity
        touching = depth > 0.0
        normal = stiffness * depth - damping * upward_velocity
        pushing = touching & (normal > 0.0)
        normal = jnp.where(pushing, normal, 0.0)
        stretch = stretch + timestep * tangential_velocity
        limit = friction * normal
        sticking = -stiffness * stretch - damping * tangential_velocity
        mass = timestep * damping if implicit else 0.0
        longest = limit / stiffness
        return ContactForce(
            tangential=_within(limit, sticking),
            normal=normal,
            added_mass=jnp.where(pushing, mass, 0.0),
            stretch=jnp.where(touching, _within(longest, stretch), 0.0),
            touching=touching,
        )

    def _at(self, footing: Footing | None) -> tuple[Any, Any, Any]:
        """Returns stiffness, damping and friction on some soil."""
        if footing is None:
            return self.stiffness, self.damping, self.friction
        softer = footing.stiffness
        return softer * self.stiffness, softer * self.damping, footing.friction * self.friction


def _within(limit: Float[Array, ""], vector: Float[Array, "*plane"]) -> Float[Array, "*plane"]:
    """Returns the vector, shortened to the limit where it is longer."""
    if not vector.ndim:
        return jnp.clip(vector, -limit, limit)
    square = jnp.sum(vector**2)
    too_long = square > limit**2
    return vector * jnp.where(
        too_long, limit * jax.lax.rsqrt(jnp.where(too_long, square, 1.0)), 1.0
    )
