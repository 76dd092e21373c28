"""Ant-v5: four legs in space, with the forces of contacts among what it senses."""

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from mjxwalk.envs import checks
from mjxwalk.envs.gymnasium import naming
from mjxwalk.envs.gymnasium.healthy import HealthyTask
from mjxwalk.envs.gymnasium.state import TaskState

_TORSO = 1  # number of the body
_UNSEEN = 2  # positions: x and y
_HEIGHT = 2  # place in the positions


@dataclasses.dataclass(frozen=True, kw_only=True)
class Ant(HealthyTask):
    """Gymnasium's Ant-v5.

    Attributes:
      contact_cost_weight: cost of the sum of the squared contact forces and torques.
      contact_force_range: to which each of them is cut, N and N m.
    """

    ID: ClassVar[str] = "Ant-v5"
    FILE: ClassVar[str] = "ant.xml"
    TOLD: ClassVar[tuple[str, ...]] = ("ahead", "cfrc_ext")
    NORMAL_RATES: ClassVar[bool] = True

    frame_skip: int = 5
    ctrl_cost_weight: float = 0.5
    reset_noise_scale: float = 0.1
    healthy_z_range: tuple[float, float] = (0.2, 1.0)
    contact_cost_weight: float = 5e-4
    contact_force_range: tuple[float, float] = (-1.0, 1.0)

    def __post_init__(self) -> None:
        checks.finite(self, "contact_cost_weight")
        naming.check_range(self, "contact_force_range")
        super().__post_init__()

    def place(self, data: Any) -> Float[Array, ""]:
        """Returns where along x the torso is, m."""
        return data.xpos[_TORSO, 0]

    def observe(self, state: TaskState, /) -> Float[Array, " obs"]:
        """Returns positions but for x and y, velocities, and contact forces, which are cut."""
        return jnp.concatenate([state.qpos[_UNSEEN:], state.qvel, self._forces(state)[1:].ravel()])

    def names_of(self, found: Any) -> tuple[str, ...]:
        """Returns what each number of an observation is."""
        places, rates = naming.positions(found), naming.rates(found)
        return (*places[_UNSEEN:], *rates, *naming.contacts(found))

    def is_healthy(self, state: TaskState) -> Bool[Array, ""]:
        """Returns whether the height is in its range."""
        lowest, highest = self.healthy_z_range
        return (lowest <= state.qpos[_HEIGHT]) & (state.qpos[_HEIGHT] <= highest)

    def reward(
        self,
        after: TaskState,
        speed: Float[Array, ""],
        ctrl: Float[Array, " act"],
        action: Float[Array, " act"],
    ) -> Float[Array, ""]:
        """Returns speed and health, less the cost of the action and of contacts."""
        del ctrl
        cost = self.ctrl_cost_weight * jnp.sum(action**2)
        cost += self.contact_cost_weight * jnp.sum(self._forces(after) ** 2)
        return self.forward_reward_weight * speed + self.alive(after) - cost

    def _forces(self, state: TaskState) -> Float[Array, "body 6"]:
        return jnp.clip(jnp.asarray(state.told.cfrc_ext), *self.contact_force_range)
