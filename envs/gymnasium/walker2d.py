"""Walker2d-v5: two legs in the plane."""

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from mjxwalk.envs.gymnasium import naming
from mjxwalk.envs.gymnasium.healthy import HealthyTask
from mjxwalk.envs.gymnasium.state import TaskState

FASTEST_SEEN = 10.0  # m/s and rad/s; velocities are cut to it in the observation


@dataclasses.dataclass(frozen=True, kw_only=True)
class Walker2d(HealthyTask):
    """Gymnasium's Walker2d-v5.

    Attributes:
      healthy_angle_range: of the torso's pitch, rad.
    """

    ID: ClassVar[str] = "Walker2d-v5"
    FILE: ClassVar[str] = "walker2d_v5.xml"

    frame_skip: int = 4
    ctrl_cost_weight: float = 1e-3
    reset_noise_scale: float = 5e-3
    healthy_z_range: tuple[float, float] = (0.8, 2.0)
    healthy_angle_range: tuple[float, float] = (-1.0, 1.0)

    def __post_init__(self) -> None:
        naming.check_range(self, "healthy_angle_range")
        super().__post_init__()

    def observe(self, state: TaskState, /) -> Float[Array, " obs"]:
        """Returns positions but for x, and velocities, which are cut."""
        rates = jnp.clip(state.qvel, -FASTEST_SEEN, FASTEST_SEEN)
        return jnp.concatenate([state.qpos[1:], rates])

    def names_of(self, found: Any) -> tuple[str, ...]:
        """Returns what each number of an observation is."""
        return (*naming.positions(found)[1:], *naming.rates(found))

    def is_healthy(self, state: TaskState) -> Bool[Array, ""]:
        """Returns whether height and pitch are in their ranges."""
        height, pitch = state.qpos[1], state.qpos[2]
        (lowest, highest), (back, front) = self.healthy_z_range, self.healthy_angle_range
        return (lowest < height) & (height < highest) & (back < pitch) & (pitch < front)

    def reward(
        self,
        after: TaskState,
        speed: Float[Array, ""],
        ctrl: Float[Array, " act"],
        action: Float[Array, " act"],
    ) -> Float[Array, ""]:
        """Returns speed and health, less the cost of the action."""
        del ctrl
        cost = self.ctrl_cost_weight * jnp.sum(action**2)
        return self.forward_reward_weight * speed + self.alive(after) - cost
