"""Walks one walker again and records what happens, frame by frame."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mjxwalk.controllers import LinearReactive
from mjxwalk.envs import Planar7, State, Terrain
from mjxwalk.rollout import Walk, advance, start


class Recording(NamedTuple):
    """A trial at a fixed frame rate; numpy arrays.

    Attributes:
      time: s.
      qpos: hip x and z (m), pitch and joints (rad).
      touching: heel and toe of the left, then of the right foot.
      done: whether the trial had ended; frames after it repeat its last state.
    """

    time: Float[np.ndarray, " frame"]
    qpos: Float[np.ndarray, "frame 9"]
    touching: Bool[np.ndarray, "frame 4"]
    done: Bool[np.ndarray, " frame"]


def record(
    env: Planar7,
    controller: LinearReactive,
    genotype: Any,
    terrain: Terrain,
    *,
    duration: float,
    frames_per_second: float = 50.0,
) -> Recording:
    """Returns the first `duration` seconds of a walker's trial."""
    steps_per_frame = round(1.0 / (frames_per_second * env.timestep))
    num_frames = round(duration * frames_per_second)

    def step(_: Any, walk: Walk) -> Walk:
        after = advance(env, controller, genotype, terrain, walk)
        ended = walk.state.done
        return jax.tree.map(lambda old, new: jnp.where(ended, old, new), walk, after)

    def frame(walk: Walk, _: None) -> tuple[Walk, State]:
        return jax.lax.fori_loop(0, steps_per_frame, step, walk), walk.state

    @jax.jit
    def run(walk: Walk) -> State:
        return jax.lax.scan(frame, walk, length=num_frames)[1]

    states = jax.tree.map(np.asarray, run(start(env, controller, genotype, terrain)))
    time = np.asarray(states.num_steps * env.timestep, np.float32)
    return Recording(time, states.qpos, states.touching, states.done)


def skeleton(env: Planar7, recording: Recording) -> Float[np.ndarray, "frame leg point 2"]:
    """Returns x and z of shoulder, hip, knee, ankle, heel, toe and ankle again, for each leg, m."""
    qpos = recording.qpos
    model = env.model.mujoco
    shoulder = 2 * model.body("torso").ipos[2]  # the head and arms reach as far above the centre
    legs = []
    for leg, first in (("left", 3), ("right", 6)):
        thigh = -model.body(f"shank_{leg}").pos[2]
        shank = -model.body(f"foot_{leg}").pos[2]
        pitch = qpos[:, 2]
        hip = qpos[:, :2]
        thigh_pitch = pitch - qpos[:, first]
        shank_pitch = thigh_pitch + qpos[:, first + 1]
        foot_pitch = shank_pitch - qpos[:, first + 2]
        knee = hip + _turned(thigh_pitch, 0.0, -thigh)
        ankle = knee + _turned(shank_pitch, 0.0, -shank)
        heel, toe = (
            ankle + _turned(foot_pitch, site.pos[0], site.pos[2])
            for site in (model.site(f"heel_{leg}"), model.site(f"toe_{leg}"))
        )
        legs.append([hip + _turned(pitch, 0.0, shoulder), hip, knee, ankle, heel, toe, ankle])
    return np.moveaxis(np.array(legs), (0, 1, 2), (1, 2, 0))


def _turned(pitch: Float[np.ndarray, " frame"], x: float, z: float) -> Any:
    """Returns a vector of a link that is pitched forward, world x and z."""
    sin, cos = np.sin(pitch), np.cos(pitch)
    return np.stack([cos * x + sin * z, cos * z - sin * x], axis=-1)
