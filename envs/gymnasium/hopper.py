"""Hopper-v5: one leg in the plane."""

import dataclasses
from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Bool

from mjxwalk.envs.gymnasium import naming
from mjxwalk.envs.gymnasium.state import TaskState
from mjxwalk.envs.gymnasium.walker2d import Walker2d


@dataclasses.dataclass(frozen=True, kw_only=True)
class Hopper(Walker2d):
    """Gymnasium's Hopper-v5.

    Attributes:
      healthy_state_range: of all positions but x and height, and all velocities.
    """

    ID: ClassVar[str] = "Hopper-v5"
    FILE: ClassVar[str] = "hopper.xml"

    healthy_z_range: tuple[float, float] = (0.7, 1e10)  # Gymnasium's has no end
    healthy_angle_range: tuple[float, float] = (-0.2, 0.2)
    healthy_state_range: tuple[float, float] = (-100.0, 100.0)

    def __post_init__(self) -> None:
        naming.check_range(self, "healthy_state_range")
        super().__post_init__()

    def is_healthy(self, state: TaskState) -> Bool[Array, ""]:
        """Returns whether height, pitch and all else are in their ranges."""
        rest = jnp.concatenate([state.qpos[2:], state.qvel])
        least, most = self.healthy_state_range
        return super().is_healthy(state) & jnp.all((least < rest) & (rest < most))
