"""What Gymnasium's tasks have in common that reward health."""

import abc
import dataclasses

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from mjxwalk.envs import checks
from mjxwalk.envs.gymnasium import naming
from mjxwalk.envs.gymnasium.state import TaskState
from mjxwalk.envs.gymnasium.task import GymnasiumTask


@dataclasses.dataclass(frozen=True, kw_only=True)
class HealthyTask(GymnasiumTask):
    """A task that rewards health, and ends without it.

    Attributes:
      healthy_reward: of each step that ends healthy; 0 removes the bonus of being alive.
      terminate_when_unhealthy: whether a step that ends unhealthy is a fall, which ends the trial.
      healthy_z_range: of the torso's height, m.
    """

    healthy_reward: float = 1.0
    terminate_when_unhealthy: bool = True
    healthy_z_range: tuple[float, float]

    def __post_init__(self) -> None:
        checks.finite(self, "healthy_reward")
        naming.check_range(self, "healthy_z_range")
        super().__post_init__()

    @abc.abstractmethod
    def is_healthy(self, state: TaskState) -> Bool[Array, ""]:
        """Returns whether a body is as the task wants it."""

    def terminated(self, state: TaskState) -> Bool[Array, ""]:
        """Returns whether a state ends its trial by a fall."""
        return ~self.is_healthy(state) if self.terminate_when_unhealthy else jnp.zeros((), bool)

    def alive(self, state: TaskState) -> Float[Array, ""]:
        """Returns the bonus of being alive."""
        return jnp.where(self.is_healthy(state), self.healthy_reward, 0.0)
