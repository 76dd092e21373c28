"""How high parts of a body are over the ground below them, and which of them touch it."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from mjxwalk.envs.derived.source import geoms_of
from mjxwalk.envs.state import State
from mjxwalk.envs.trees import Instant
from mjxwalk.envs.trial import Trial


def clear(env: Any, state: State, now: Instant, given: Trial) -> Float[Array, " leg"]:
    """Returns how high feet are over the ground below them, more than at the start, m.

    Args:
      env: an `MjcfEnv`.
      state: of the walker.
      now: from `Tree.see` of that state.
      given: the trial.
    """
    feet = _places(env, state, now, tuple(leg.foot for leg in env.anatomy.legs))
    return feet[:, 2] - _grounds(env, given, feet) - np.array(env.stance.feet, np.float32)


def touches(env: Any, state: State, now: Instant, given: Trial) -> Bool[Array, ""]:
    """Returns whether a sphere about a forbidden body touches the ground; see `clear`."""
    places = _places(env, state, now, env.forbidden)
    radii = np.array(forbidden_radii(env), np.float32)
    return jnp.any(places[:, 2] - radii < _grounds(env, given, places))


def forbidden_radii(env: Any) -> tuple[float, ...]:
    """Returns radii of spheres at bodies' origins, m; ours: half of a body's largest geom's."""
    model = env.model.mujoco
    geoms = [geoms_of(model, model.body(name).id) for name in env.forbidden]
    return tuple(0.5 * max(model.geom_rbound[own], default=0.0) for own in geoms)


def _places(env: Any, state: State, now: Instant, names: tuple[str, ...]) -> Float[Array, "body 3"]:
    """Returns where bodies are in the world, m."""
    bodies = np.array([env.model.mujoco.body(name).id for name in names])
    places = now.data.xpos[bodies]
    if now.axes is None:
        return places + jnp.stack([state.qpos[0], jnp.zeros(()), state.qpos[1]])
    return state.qpos[:3] + places @ now.axes.T


def _grounds(env: Any, given: Trial, places: Float[Array, "body 3"]) -> Float[Array, " body"]:
    planar = env.anatomy.root.is_planar
    heights = [env.ground_height(given, x, None if planar else y) for x, y, _ in places]
    return jnp.stack(heights)
