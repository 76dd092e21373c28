"""The walking task for gymnasium, one walker or many at once."""

import functools
from pathlib import Path
from typing import Any

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv

from mjxwalk import forking
from mjxwalk.envs import BODIES
from mjxwalk.gym import bodies
from mjxwalk.gym.mjx_env import MjxEnv, State

DEFAULT = next(iter(BODIES))
RENDER_SIZE = (480, 360)


def make_task(body: str | Path | None, env: Any) -> MjxEnv:
    """Returns the task of a body by name or file, or of an environment with settings of its own.

    Raises:
      ValueError: there is no such body, or its file is refused.
      RunError: the body is a run whose settings cannot be read.
    """
    return MjxEnv(bodies.make(body) if env is None else env)


@functools.lru_cache(maxsize=8)
def _compiled(env: Any) -> tuple[Any, Any]:
    """Returns reset and step, compiled once for all environments of one body and its settings."""
    task = MjxEnv(env)
    return jax.jit(task.reset), jax.jit(task.step)


def _spaces(task: MjxEnv) -> tuple[spaces.Box, spaces.Box]:
    """Returns what a policy sees, and what it does."""
    seen = spaces.Box(-np.inf, np.inf, (task.observation_size,), np.float32)
    return seen, spaces.Box(-1.0, 1.0, (task.action_size,), np.float32)


def as_actions(actions: Any, shape: tuple[int, ...]) -> Any:
    """Returns actions as JAX has them.

    Raises:
      ValueError: they are no finite numbers, or not one for each motor.
    """
    try:
        given = np.asarray(actions, np.float32)
    except (TypeError, ValueError):
        raise ValueError(f"action must hold numbers, got {type(actions).__name__}") from None
    if given.shape != shape:
        raise ValueError(f"action must have shape {shape}, got {given.shape}")
    if not np.isfinite(given).all():
        raise ValueError(f"action must be finite, got {given[~np.isfinite(given)][0]}")
    return jnp.asarray(given)


class WalkerEnv(gymnasium.Env[Any, Any]):
    """One walker; every reset gives it a new terrain. The return is what it is worth.

    That is the distance, m, or what the terms of a body of a file come to.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 100}

    def __init__(
        self,
        body: str | Path | None = DEFAULT,
        env: Any = None,
        render_mode: str | None = None,
    ) -> None:
        """Makes the environment.

        Args:
          body: one of `mjxwalk.envs.BODIES`, a body that ships, an MJCF or URDF file, or a run's
            folder for its body, ground and rules.
          env: a body with other settings, such as a rougher terrain, in place of the usual one.
          render_mode: "rgb_array" or None.

        Raises:
          ValueError: there is no such body or mode, or the body's file is refused.
          RunError: the body is a run whose settings cannot be read.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode must be rgb_array or None, got {render_mode!r}")
        self.task = make_task(body, env)
        self.metadata = {**type(self).metadata, "render_fps": round(1.0 / self.task.dt)}
        self.render_mode = render_mode
        self.observation_space, self.action_space = _spaces(self.task)
        self._reset, self._step = _compiled(self.task.env)
        self._state: State | None = None
        self._painter: Any = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Returns what the walker sees at the start, and nothing else to know.

        Raises:
          ForkedError: JAX cannot compute in this process.
        """
        forking.check()
        super().reset(seed=seed)
        del options
        state = self._reset(jax.random.key(int(self.np_random.integers(2**31))))
        self._state = state
        return np.array(state.obs), {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Returns what it sees, its reward, whether it fell, whether its trial is over otherwise.

        Raises:
          ForkedError: JAX cannot compute in this process.
          RuntimeError: it was not reset before.
          ValueError: the action is not one finite number for each motor.
        """
        forking.check()
        if self._state is None:
            raise RuntimeError("call reset before step")
        state = self._step(self._state, as_actions(action, (self.task.action_size,)))
        self._state = state
        fell, done = bool(state.data.trial.fell), bool(state.done)
        told = {name: float(value) for name, value in state.metrics.items()}
        return np.array(state.obs), float(state.reward), fell, done and not fell, told

    def render(self) -> Any:
        """Returns a picture, None without a render mode."""
        if self.render_mode is None or self._state is None:
            return None
        from mjxwalk.pictures.still import Still

        data, info = self._state.data, self._state.info
        if self._painter is None:
            self._painter = Still(self.task.env, RENDER_SIZE)
        ground = info["trials"].given(info["row"]).ground
        return self._painter.picture(ground, np.asarray(data.qpos, np.float64))

    def close(self) -> None:
        """Gives the pictures' OpenGL back."""
        if self._painter is not None:
            self._painter.close()
            self._painter = None


class WalkerVectorEnv(VectorEnv[Any, Any, Any]):
    """Many walkers in one compiled step; who is done starts anew on its next step."""

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        body: str | Path | None = DEFAULT,
        env: Any = None,
        num_terrains: int = 64,
        render_mode: str | None = None,
    ) -> None:
        """Makes the environment.

        Args:
          num_envs: walkers.
          body: as for `WalkerEnv`.
          env: as for `WalkerEnv`.
          num_terrains: that they walk on; each trial takes one of them.
          render_mode: None, as many cannot be drawn.

        Raises:
          ValueError: there is no such body or mode, its file is refused, or a number is below 1.
          RunError: the body is a run whose settings cannot be read.
        """
        if min(num_envs, num_terrains) < 1:
            raise ValueError(
                f"num_envs and num_terrains must be at least 1, got {num_envs} and {num_terrains}"
            )
        if render_mode is not None:
            raise ValueError(f"render_mode must be None of many walkers, got {render_mode!r}")
        self.task = make_task(body, env)
        self.num_envs = num_envs
        self.render_mode = None
        self.single_observation_space, self.single_action_space = _spaces(self.task)
        batch = gymnasium.vector.utils.batch_space
        self.observation_space = batch(self.single_observation_space, num_envs)
        self.action_space = batch(self.single_action_space, num_envs)
        self._num_terrains = num_terrains
        self._compiled_step = jax.jit(self._advance)
        self._trials: Any = None
        self._key: Any = None
        self._datas: Any = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Returns what all walkers see at the start, on new terrains.

        Raises:
          ForkedError: JAX cannot compute in this process.
        """
        forking.check()
        super().reset(seed=seed)
        del options
        self._key, key_terrain = jax.random.split(
            jax.random.key(int(self.np_random.integers(2**31)))
        )
        self._trials = self.task.env.sample_trials(key_terrain, self._num_terrains)
        self._key, key = jax.random.split(self._key)
        self._datas, obs = jax.jit(self._started)(key, self._trials)
        return np.array(obs), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Returns what all see, rewards, who fell, whose trial is over otherwise, and figures.

        Raises:
          ForkedError: JAX cannot compute in this process.
          RuntimeError: it was not reset before.
          ValueError: the actions are not one finite number for each motor of each walker.
        """
        forking.check()
        if self._datas is None:
            raise RuntimeError("call reset before step")
        given = as_actions(actions, (self.num_envs, self.task.action_size))
        self._key, key = jax.random.split(self._key)
        self._datas, found = self._compiled_step(self._datas, given, key, self._trials)
        obs, reward, fell, done, metrics = jax.tree.map(np.array, found)
        known = {f"_{name}": np.ones(self.num_envs, bool) for name in metrics}
        return obs, reward.astype(np.float64), fell, done & ~fell, metrics | known

    def _started(self, key: Any, trials: Any) -> tuple[Any, Any]:
        rows = jax.random.randint(key, (self.num_envs,), 0, self._num_terrains)

        def begin(row: Any) -> tuple[Any, Any]:
            state = self.task.begin(trials, row, key)
            return (state.data, row), state.obs

        return jax.vmap(begin)(rows)

    def _advance(self, datas: Any, actions: Any, key: Any, trials: Any) -> tuple[Any, Any]:
        anew, _ = self._started(key, trials)

        def one(old: Any, new: Any, action: Any) -> tuple[Any, Any]:
            was_done = old[0].trial.done
            data, row = jax.tree.map(lambda a, b: jnp.where(was_done, b, a), old, new)
            begun = self.task.begin(trials, row, key).replace(data=data)
            after = self.task.step(begun, action)
            # A walker that starts anew does nothing in this step, whatever it is told.
            kept = jax.tree.map(lambda a, b: jnp.where(was_done, a, b), data, after.data)
            reward = jnp.where(was_done, 0.0, after.reward)
            return (kept, row), (
                self.task.observe(kept),
                reward,
                kept.trial.fell,
                kept.trial.done,
                {"distance_m": kept.qpos[0], "torque_cost": kept.trial.torque_cost},
            )

        return jax.vmap(one)(datas, anew, actions)
