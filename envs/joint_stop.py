"""Soft joint limits: one-sided springs and dampers beyond a joint's range."""

import dataclasses
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from mjxwalk.envs import checks


class StopTorque(NamedTuple):
    """Torque that pushes joints back into their range, and its implicit part.

    Attributes:
      torque: N m.
      added_inertia: belongs on the diagonal of the mass matrix, kg m^2.
    """

    torque: Float[Array, " joint"]
    added_inertia: Float[Array, " joint"]


@dataclasses.dataclass(frozen=True, kw_only=True)
class JointStop:
    """Stiff spring and damper that act beyond the range only, and only inwards.

    Solomon et al. (2013), section 2.1: hand-tuned gains, typically under a degree of overshoot.

    Attributes:
      stiffness: N m/rad.
      damping: N m s/rad.
    """

    stiffness: float = 3_000.0  # ours: Table 2 is lost; this keeps overshoot near a degree
    damping: float = 40.0  # ours: as above, without bouncing back

    def __post_init__(self) -> None:
        checks.positive(self, "stiffness")
        checks.not_negative(self, "damping")

    def torque(
        self,
        angle: Float[Array, " joint"],
        rate: Float[Array, " joint"],
        lower: Float[np.ndarray, " joint"],
        upper: Float[np.ndarray, " joint"],
        *,
        timestep: float,
        implicit: bool,
    ) -> StopTorque:
        """Returns the stops' torque; see `SoftContact.force` for the implicit part."""
        damping = self.damping + (self.stiffness * timestep if implicit else 0.0)
        below, above = lower - angle, angle - upper
        push = self.stiffness * jnp.where(below > 0.0, below, -above) - damping * rate
        acting = ((below > 0.0) & (push > 0.0)) | ((above > 0.0) & (push < 0.0))
        inertia = timestep * damping if implicit else 0.0
        return StopTorque(
            torque=jnp.where(acting, push, 0.0), added_inertia=jnp.where(acting, inertia, 0.0)
        )
