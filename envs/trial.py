"""The rules of a trial that all bodies share: what is counted, and what ends it."""

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float


@runtime_checkable
class Rules(Protocol):
    """Settings of a body that its trials end by; `Planar7` says what each is."""

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


def begin() -> dict[str, Array]:
    """Returns those fields of a body's state that a trial counts, and how it stands, by name."""
    zero, no = jnp.zeros(()), jnp.zeros((), bool)
    return {
        "num_steps": jnp.zeros((), jnp.int32),
        "flight_time": zero,
        "torque_cost": zero,
        "work": zero,
        "fell": no,
        "diverged": no,
        "done": no,
    }


def count(
    rules: Rules,
    state: Any,
    *,
    touching: Bool[Array, " point"],
    torque: Float[Array, " motor"],
    rate: Float[Array, " motor"],
) -> Any:
    """Returns the state with one more step counted.

    Args:
      rules: of the trial.
      state: with a body's `State` fields of the trial.
      touching: which points of the feet touch the ground.
      torque: of the motors, N m.
      rate: of their joints, rad/s.
    """
    dt = rules.timestep
    return state._replace(
        num_steps=state.num_steps + 1,
        flight_time=jnp.where(touching.any(), 0.0, state.flight_time + dt),
        torque_cost=state.torque_cost + dt * jnp.abs(torque).sum(),
        work=state.work + dt * jnp.abs(torque * rate).sum(),
    )


def judge(
    rules: Rules,
    before: Any,
    after: Any,
    *,
    max_speed: Float[np.ndarray, " coordinate"],
    has_fallen: Callable[[Any], Bool[Array, ""]],
) -> Any:
    """Returns the state after a step with the trial's end in it, if it is one.

    Args:
      rules: of the trial.
      before: the step; what is left if the physics diverged.
      after: the step.
      max_speed: of each coordinate; beyond these a simulation has diverged.
      has_fallen: the body's own rules, of a state; too long a flight is a fall of every body.
    """
    # One comparison catches NaN, infinity and runaway speeds alike.
    sound = jnp.sum((after.qvel / max_speed) ** 2) < 1.0
    after = jax.tree.map(lambda new, old: jnp.where(sound, new, old), after, before)
    fell = has_fallen(after) | (after.flight_time > rules.max_flight_time) | ~sound
    spent = after.torque_cost >= rules.torque_budget
    late = after.num_steps >= round(rules.max_time / rules.timestep)
    lag = rules.min_speed * rules.timestep * after.num_steps - after.qpos[0]
    done = fell | spent | late | (lag > rules.max_lag)
    return after._replace(fell=fell, diverged=~sound, done=done)
