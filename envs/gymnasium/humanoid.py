"""Humanoid-v5: a man in space, who senses inertias, velocities and forces of all his parts."""

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
_ROOT = 6  # degrees of freedom


@dataclasses.dataclass(frozen=True, kw_only=True)
class Humanoid(HealthyTask):
    """Gymnasium's Humanoid-v5.

    Attributes:
      contact_cost_weight: cost of the sum of the squared contact forces and torques.
      contact_cost_range: to which this cost is cut.
    """

    ID: ClassVar[str] = "Humanoid-v5"
    FILE: ClassVar[str] = "humanoid.xml"
    TOLD: ClassVar[tuple[str, ...]] = ("ahead", "cinert", "cvel", "qfrc_actuator", "cfrc_ext")

    frame_skip: int = 5
    forward_reward_weight: float = 1.25
    ctrl_cost_weight: float = 0.1
    reset_noise_scale: float = 1e-2
    healthy_reward: float = 5.0
    healthy_z_range: tuple[float, float] = (1.0, 2.0)
    contact_cost_weight: float = 5e-7
    contact_cost_range: tuple[float, float] = (-1e10, 10.0)  # Gymnasium's has no begin

    def __post_init__(self) -> None:
        checks.finite(self, "contact_cost_weight")
        naming.check_range(self, "contact_cost_range")
        super().__post_init__()

    def place(self, data: Any) -> Float[Array, ""]:
        """Returns where along x the centre of mass is, m."""
        return data.subtree_com[_TORSO, 0]

    def observe(self, state: TaskState, /) -> Float[Array, " obs"]:
        """Returns positions but for x and y, velocities, and all that MuJoCo tells."""
        told = state.told
        rows = [jnp.asarray(each)[1:].ravel() for each in (told.cinert, told.cvel)]
        driven, forces = jnp.asarray(told.qfrc_actuator)[_ROOT:], jnp.asarray(told.cfrc_ext)
        return jnp.concatenate(
            [state.qpos[_UNSEEN:], state.qvel, *rows, driven, forces[1:].ravel()]
        )

    def names_of(self, found: Any) -> tuple[str, ...]:
        """Returns what each number of an observation is."""
        return (
            *naming.positions(found)[_UNSEEN:],
            *naming.rates(found),
            *naming.inertias(found),
            *naming.velocities(found),
            *naming.motors(found)[_ROOT:],
            *naming.contacts(found),
        )

    def is_healthy(self, state: TaskState) -> Bool[Array, ""]:
        """Returns whether the height is in its range."""
        lowest, highest = self.healthy_z_range
        return (lowest < state.qpos[_HEIGHT]) & (state.qpos[_HEIGHT] < highest)

    def reward(
        self,
        after: TaskState,
        speed: Float[Array, ""],
        ctrl: Float[Array, " act"],
        action: Float[Array, " act"],
    ) -> Float[Array, ""]:
        """Returns speed and health, less the cost of controls and of contacts."""
        del action
        contact = self.contact_cost_weight * jnp.sum(jnp.asarray(after.told.cfrc_ext) ** 2)
        cost = self.ctrl_cost_weight * jnp.sum(ctrl**2)
        cost += jnp.clip(contact, *self.contact_cost_range)
        return self.forward_reward_weight * speed + self.alive(after) - cost
