"""What a task of one's own can be derived from, where the walker is a few numbers."""

import abc
import dataclasses
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from mjxwalk.envs import checks
from mjxwalk.envs.trial import Trials, TrialState, noise_seeds


@dataclasses.dataclass(frozen=True, kw_only=True)
class FlatEnv(abc.ABC):
    """An environment whose observation and action are arrays of one axis, with named numbers.

    A subclass, a frozen dataclass, gives the names and writes `reset`, `observe` and `step`. Its
    state is a `NamedTuple` with `qpos`, an array whose first number is how far the walker came, m,
    and `trial`, which begins as `TrialState.begin()` and which `step` has from `count`.

    Attributes:
      timestep: of one step, s.
      max_time: after which a trial ends, s.
      action_noise: standard deviation of normal noise on the actions of evolving walkers.
    """

    observation_names: ClassVar[tuple[str, ...]]
    action_names: ClassVar[tuple[str, ...]]
    num_draws: ClassVar[int] = 0  # random numbers from -1 to 1 that each trial has, as given.start

    timestep: float = 0.02
    max_time: float = 10.0
    action_noise: float = 0.0

    def __post_init__(self) -> None:
        checks.positive(self, "timestep", "max_time")
        checks.not_negative(self, "action_noise")

    def sample_trials(self, key: PRNGKeyArray, num: int, roughness: float | None = None) -> Trials:
        """Returns trials on level ground, each with its random numbers; they have no roughness."""
        del roughness
        draws = jax.random.uniform(key, (num, self.num_draws), minval=-1.0, maxval=1.0)
        noise = noise_seeds(key, num, self.action_noise)
        return Trials(jnp.zeros((num, 1)), start=draws if self.num_draws else None, noise=noise)

    def count(self, trial: TrialState, *, fell: Bool[Array, ""] | bool = False) -> TrialState:
        """Returns the trial one step later; it has ended by a fall, or after its longest time.

        Args:
          trial: before the step.
          fell: whether the walker fell in this step.
        """
        steps = trial.num_steps + 1
        is_late = steps >= round(self.max_time / self.timestep)
        fell = jnp.asarray(fell)
        return trial._replace(num_steps=steps, fell=trial.fell | fell, done=fell | is_late)

    @abc.abstractmethod
    def reset(self, given: Any, /) -> Any:
        """Returns the state that a trial starts in."""

    @abc.abstractmethod
    def observe(self, state: Any, /) -> Float[Array, " obs"]:
        """Returns what the walker senses: a number for each of `observation_names`."""

    @abc.abstractmethod
    def step(self, state: Any, action: Float[Array, " act"], given: Any, /) -> Any:
        """Returns the state one step later.

        Args:
          state: before.
          action: a number from -1 to 1 for each of `action_names`.
          given: the trial.
        """

    def fitness(self, state: Any, /) -> Float[Array, ""]:
        """Returns the fitness of a walker whose trial has ended: how far it came, m."""
        return state.qpos[0]
