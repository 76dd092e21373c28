"""A trial: what a walker is given, what is counted, and the rules by which every trial ends."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray, UInt32

from mjxwalk.envs.terrain import Terrain

NOISE = 0x6E6F6973  # folded into the key of the trials, it leads to draws of their own


class Trial(NamedTuple):
    """What one walker is given.

    Attributes:
      ground: that it walks on.
      start: how far its start is from the usual one: a draw from -1 to 1 for each of the body's
        `START_DEPARTURES`; None for the usual start.
      load: what the upper body carries, as a draw from -1 to 1 of the body's largest load; None for
        nothing.
      push: when each push begins, s, and by what it changes the body's velocity along x and y,
        m/s; None where there are none.
      noise: what the noise on the walker's actions is made from; None where there is none.
    """

    ground: Terrain
    start: Float[Array, "*walker departure"] | None = None
    load: Float[Array, "*walker"] | None = None
    push: Float[Array, "*walker push 3"] | None = None
    noise: UInt32[Array, "*walker"] | None = None


class Trials(NamedTuple):
    """Several trials, one a row.

    Attributes:
      heights: of each ground's nodes, m.
      start: as in `Trial`.
      load: as in `Trial`.
      course: of each ground, as in `Terrain`.
      push: as in `Trial`.
      noise: as in `Trial`.
    """

    heights: Any
    start: Any = None
    load: Any = None
    course: Any = None
    push: Any = None
    noise: Any = None

    @property
    def num(self) -> int:
        """How many there are."""
        return self.heights.shape[0]

    def take(self, rows: Any) -> "Trials":
        """Returns some of the trials: a slice, or an array of rows."""
        return jax.tree.map(lambda leaf: leaf[rows], self)

    def given(self, rows: Any) -> Trial:
        """Returns the trial of one walker, or those of several walkers, which share the grounds.

        Args:
          rows: of the trial that each walker is given; one number for one walker.
        """
        parts = self.start, self.load, self.push, self.noise
        own = jax.tree.map(lambda leaf: leaf[rows], parts)
        return Trial(Terrain(self.heights, rows, self.course), *own)

    def with_grounds(self, rows: Any) -> "Trials":
        """Returns the trials with other grounds in their table: those of some rows."""
        heights, course = jax.tree.map(lambda leaf: leaf[rows], (self.heights, self.course))
        return self._replace(heights=heights, course=course)


# Which axis of a `Trial` counts walkers, for `vmap`: they share the table of heights.
TRIAL_AXES = Trial(Terrain(None, 0), 0, 0, 0, 0)  # type: ignore[arg-type]


def noise_seeds(key: PRNGKeyArray, num: int, deviation: float) -> UInt32[Array, " trial"] | None:
    """Returns what each trial's noise on actions is made from; None where it deviates by nothing.

    Args:
      key: that the trials were drawn by.
      num: of the trials.
      deviation: standard deviation of the noise.
    """
    if not deviation:
        return None
    return jax.random.bits(jax.random.fold_in(key, NOISE), (num,), jnp.uint32)


class TrialState(NamedTuple):
    """What is counted in a trial, and how it stands.

    Attributes:
      num_steps: physics steps so far.
      flight_time: since a foot last touched the ground, s.
      torque_cost: integral of the motors' summed absolute torque, N m s.
      work: integral of the motors' summed absolute power, J.
      fell: whether the trial ended by a fall, or by physics that diverged.
      diverged: whether the physics diverged; the rest is then the last sound state.
      done: whether the trial has ended.
    """

    num_steps: Int[Array, "*batch"]
    flight_time: Float[Array, "*batch"]
    torque_cost: Float[Array, "*batch"]
    work: Float[Array, "*batch"]
    fell: Bool[Array, "*batch"]
    diverged: Bool[Array, "*batch"]
    done: Bool[Array, "*batch"]

    @classmethod
    def begin(cls) -> "TrialState":
        """Returns that of a trial that has not begun to count."""
        zero, no = jnp.zeros(()), jnp.zeros((), bool)
        return cls(jnp.zeros((), jnp.int32), zero, zero, zero, no, no, no)


@runtime_checkable
class Rules(Protocol):
    """Settings by which trials end; `mjxwalk.envs.LeggedEnv` says what each is."""

    @property
    def timestep(self) -> float: ...
    @property
    def max_flight_time(self) -> float: ...
    @property
    def min_speed(self) -> float: ...
    @property
    def max_lag(self) -> float: ...
    @property
    def torque_budget(self) -> float: ...
    @property
    def max_time(self) -> float: ...


def count(
    rules: Rules,
    trial: TrialState,
    *,
    touching: Bool[Array, " point"],
    torque: Float[Array, " motor"],
    rate: Float[Array, " motor"],
) -> TrialState:
    """Returns the trial with one more step counted.

    Args:
      rules: of the trial.
      trial: before the step.
      touching: which points of the feet touch the ground.
      torque: of the motors, N m.
      rate: of their joints, rad/s.
    """
    dt = rules.timestep
    return trial._replace(
        num_steps=trial.num_steps + 1,
        flight_time=jnp.where(touching.any(), 0.0, trial.flight_time + dt),
        torque_cost=trial.torque_cost + dt * jnp.abs(torque).sum(),
        work=trial.work + dt * jnp.abs(torque * rate).sum(),
    )


def judge(
    rules: Rules,
    before: Any,
    after: Any,
    *,
    max_speed: Float[np.ndarray, " coordinate"],
    has_fallen: Callable[[Any], Bool[Array, ""]],
    is_over: Callable[[Any], Bool[Array, ""] | bool],
) -> Any:
    """Returns the state after a step with the trial's end in it, if it is one.

    Args:
      rules: of the trial.
      before: the state before the step; it is what is left if the physics diverged.
      after: the state after the step.
      max_speed: of each coordinate; beyond these a simulation has diverged.
      has_fallen: the body's own rules; too long a flight is a fall of every body.
      is_over: whether the body's own rules end the trial without a fall.
    """
    # One comparison catches NaN, infinity and runaway speeds alike.
    sound = jnp.sum((after.qvel / max_speed) ** 2) < 1.0
    after = jax.tree.map(lambda new, old: jnp.where(sound, new, old), after, before)
    trial: TrialState = after.trial
    fell = has_fallen(after) | (trial.flight_time > rules.max_flight_time) | ~sound
    spent = trial.torque_cost >= rules.torque_budget
    late = trial.num_steps >= round(rules.max_time / rules.timestep)
    lag = rules.min_speed * rules.timestep * trial.num_steps - after.qpos[0]
    done = fell | spent | late | (lag > rules.max_lag) | is_over(after)
    return after._replace(trial=trial._replace(fell=fell, diverged=~sound, done=done))
