"""HalfCheetah-v5: two legs in the plane, one behind the other; nothing ends its trial early."""

import dataclasses
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.envs.gymnasium import naming
from mjxwalk.envs.gymnasium.state import TaskState
from mjxwalk.envs.gymnasium.task import GymnasiumTask


@dataclasses.dataclass(frozen=True, kw_only=True)
class HalfCheetah(GymnasiumTask):
    """Gymnasium's HalfCheetah-v5."""

    ID: ClassVar[str] = "HalfCheetah-v5"
    FILE: ClassVar[str] = "half_cheetah.xml"
    NORMAL_RATES: ClassVar[bool] = True

    frame_skip: int = 5
    ctrl_cost_weight: float = 0.1
    reset_noise_scale: float = 0.1

    def observe(self, state: TaskState, /) -> Float[Array, " obs"]:
        """Returns positions but for x, and velocities."""
        return jnp.concatenate([state.qpos[1:], state.qvel])

    def names_of(self, found: Any) -> tuple[str, ...]:
        """Returns what each number of an observation is."""
        return (*naming.positions(found)[1:], *naming.rates(found))

    def reward(
        self,
        after: TaskState,
        speed: Float[Array, ""],
        ctrl: Float[Array, " act"],
        action: Float[Array, " act"],
    ) -> Float[Array, ""]:
        """Returns speed less the cost of the action."""
        del after, ctrl
        cost = self.ctrl_cost_weight * jnp.sum(action**2)
        return self.forward_reward_weight * speed - cost
