"""A walking task with the interface of MuJoCo Playground's environments.

Playground is not needed for it. `reset` and `step` are pure functions for one walker; the caller
maps, compiles and resets, as Brax's wrappers for training do. Our own physics moves the body.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.envs import BODIES, BodyObservation, LeggedEnv, MjcfEnv, Trials

CONTROL_SECONDS = 0.01  # ours: a hundred decisions a second, as is usual for walking robots
RATE_SCALE = 0.1  # of rates in an observation, s/rad; ours


class State(NamedTuple):
    """Where an environment is, as Playground has it.

    Attributes:
      data: state of our body; its trial comes along in `info`.
      obs: what the policy sees.
      reward: of the last step: how much farther the hip is, m, or how much more a walker of a
        file's body is worth.
      done: 1.0 if the trial is over, else 0.0.
      metrics: figures to log.
      info: all else; "trials" are those that walkers share, "key" is a random key.
    """

    data: Any
    obs: Float[Array, " obs"]
    reward: Float[Array, ""]
    done: Float[Array, ""]
    metrics: dict[str, Array]
    info: dict[str, Any]

    def replace(self, **changes: Any) -> "State":
        """Returns the state with fields changed."""
        return self._replace(**changes)


class MjxEnv:
    """A body that is to walk as far as it can, by actions from -1 to 1.

    The sum of all rewards is the distance that we evolve walkers for; of a body of a file, which
    has fitness terms, what these come to.
    """

    def __init__(self, env: Any = None, *, ctrl_dt: float = CONTROL_SECONDS):
        """Makes the task.

        Args:
          env: body, ground and rules of the trials; None for the first of `BODIES` as it is.
          ctrl_dt: from one action to the next, s.

        Raises:
          ValueError: `env` is no `LeggedEnv`, or the time is shorter than a physics step.
        """
        env = next(iter(BODIES.values()))() if env is None else env
        if not isinstance(env, LeggedEnv):
            raise ValueError(f"env must be a LeggedEnv, got {type(env).__name__}")
        if round(ctrl_dt / env.timestep) < 1:
            raise ValueError(f"ctrl_dt must be at least a step of {env.timestep} s, got {ctrl_dt}")
        self.env: LeggedEnv = env
        self._substeps = round(ctrl_dt / env.timestep)

    def reset(self, rng: PRNGKeyArray) -> State:
        """Returns a walker at the start of a trial on a terrain of its own."""
        key, key_terrain = jax.random.split(rng)
        return self.begin(self.env.sample_trials(key_terrain, 1), jnp.zeros((), jnp.int32), key)

    def begin(self, trials: Trials, row: Array, key: Any) -> State:
        """Returns a walker at the start of one of the trials that walkers share."""
        data = self.env.reset(trials.given(row))
        zero = jnp.zeros(())
        metrics = {"distance_m": data.qpos[0], "torque_cost": zero, "fell": zero}
        info = {"trials": trials, "row": row, "key": key}
        return State(
            data=data, obs=self.observe(data), reward=zero, done=zero, metrics=metrics, info=info
        )

    def step(self, state: State, action: Float[Array, " motor"]) -> State:
        """Returns the walker after one action, which lasts for several steps of the physics.

        Raises:
          ValueError: the action is not one number for each motor.
        """
        action = jnp.asarray(action, float)
        if action.shape != (self.action_size,):
            raise ValueError(f"action must have shape ({self.action_size},), got {action.shape}")
        given = state.info["trials"].given(state.info["row"])
        asked = self.env.scaled_action(action)

        def substep(_: Any, data: Any) -> Any:
            after = self.env.step(data, asked, given)
            # Who has fallen lies where it fell.
            return jax.tree.map(lambda old, new: jnp.where(data.trial.done, old, new), data, after)

        data = jax.lax.fori_loop(0, self._substeps, substep, state.data)
        metrics = {
            "distance_m": data.qpos[0],
            "torque_cost": data.trial.torque_cost,
            "fell": data.trial.fell.astype(jnp.float32),
        }
        return state.replace(
            data=data,
            obs=self.observe(data),
            reward=self._worth(data) - self._worth(state.data),
            done=data.trial.done.astype(jnp.float32),
            metrics=state.metrics | metrics,
        )

    def observe(self, data: Any) -> Float[Array, " obs"]:
        """Returns angles, scaled rates, velocity of the hip, contacts, and where the ankles are.

        Neither the time nor the place, so that what is learned holds for ever and everywhere. Of a
        body of a file, all fields of its `BodyObservation` but the time, in their order.
        """
        slides = self.env.anatomy.root.num_slides
        seen = self.env.observe(data)
        if isinstance(seen, BodyObservation):
            return _of_body(seen)
        return jnp.concatenate(
            [
                data.qpos[slides:],
                RATE_SCALE * data.qvel[slides:],
                data.qvel[:slides],
                seen.contact.astype(jnp.float32),
                seen.ankle_x,
            ]
        )

    def _worth(self, data: Any) -> Float[Array, ""]:
        """Returns what a walker is worth by now."""
        return self.env.fitness(data) if isinstance(self.env, MjcfEnv) else data.qpos[0]

    @property
    def xml_path(self) -> str:
        """The body's file, of our own bodies; `mj_model` is right of all."""
        return str(self.env.XML_PATH or "")

    @property
    def action_size(self) -> int:
        """Motors; the anatomy's `motors` tell which."""
        return len(self.env.anatomy.motors)

    @property
    def observation_size(self) -> int:
        """Numbers that the policy sees."""
        return jax.eval_shape(self.reset, jax.random.key(0)).obs.size

    @property
    def mj_model(self) -> Any:
        """The `mujoco.MjModel`."""
        return self.env.model.mujoco

    @property
    def mjx_model(self) -> Any:
        """The `mjx.Model`."""
        return self.env.model.mjx

    @property
    def dt(self) -> float:
        """From one action to the next, s."""
        return self._substeps * self.env.timestep

    @property
    def sim_dt(self) -> float:
        """Of the physics, s."""
        return self.env.timestep

    @property
    def n_substeps(self) -> int:
        """Steps of the physics in one of the environment."""
        return self._substeps

    @property
    def unwrapped(self) -> "MjxEnv":
        """Itself."""
        return self


def _of_body(seen: BodyObservation) -> Float[Array, " obs"]:
    scaled = seen._replace(turning=RATE_SCALE * seen.turning, rate=RATE_SCALE * seen.rate)
    return jnp.concatenate([part.astype(jnp.float32) for part in scaled[1:]])
