"""Walks walkers again and records what happens, frame by frame."""

import dataclasses
import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mjxwalk import budget, engines
from mjxwalk.engines import lanes, mjx
from mjxwalk.engines.pinning import pinned
from mjxwalk.envs import Flame, Planar7
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.envs.flame_body import COORDINATE, LEGS
from mjxwalk.rollout import Controller, Environment, Walk, advance, start

TORSO_HEIGHT = 0.52  # m over the hips, where flame.xml has the middle of the head


class Recording(NamedTuple):
    """Trials at a fixed frame rate; numpy arrays.

    Frames after the end of a walker's trial repeat its last state, time included.

    Attributes:
      time: since the start of the trial, s.
      done: whether the trial had ended.
      states: the environment's, leaves [frame, walker, ...].
      memories: the controllers', likewise; None where nobody kept them.
    """

    time: Float[np.ndarray, "frame walker"]
    done: Bool[np.ndarray, "frame walker"]
    states: Any
    memories: Any = None


@pinned()
def record(
    env: Environment,
    controller: Controller,
    genotypes: Any,
    terrain: Any,
    *,
    duration: float,
    frames_per_second: float = 100.0,
    engine: str = "auto",
) -> Recording:
    """Returns the first `duration` seconds of many walkers' trials, the start included.

    The recording ends earlier if all trials do. What is compiled is a number of steps, not a
    recording, so that it serves every duration and frame rate.

    Args:
      env: body, ground and rules of the trials.
      controller: what the genotypes become.
      genotypes: leaves [walker, ...].
      terrain: of the environment's type: a table of heights, m, and each walker's row of it.
      duration: s.
      frames_per_second: in the trials' time; frames fall on whole steps of the physics.
      engine: as `mjxwalk.engines.choose` knows it.

    Raises:
      ValueError: there is no such engine, the frame rate is not above zero or exceeds the physics'
        own, or the duration is below a frame.
    """
    steps = _steps_per_frame(env, duration, frames_per_second)
    num_frames = 1 + round(duration / (steps * env.timestep))
    terrain = _laid_out(terrain)
    walker, engine = _Walker(env, controller), engines.choose(engine).name
    genotypes = jax.tree.map(np.asarray, genotypes)
    first = _beginning(walker, type(terrain), engine)(genotypes, terrain)
    proceed = _proceeding(walker, type(terrain), engine, jax.tree.structure(first))

    # A call costs a thousandth of a second, however many walkers it moves and however short. So
    # walk to every 80th frame first, say, and then from all of these at once to those between.
    stride = math.isqrt(num_frames)
    posts = [first]
    frame = sum(np.asarray(leaf).nbytes for leaf in jax.tree.leaves(first))
    while stride * len(posts) < num_frames and not np.all(posts[-1].state.done):
        budget.check(
            2.0 * frame * stride * len(posts),  # the frames, and the same in their order
            f"{len(terrain.row):,} recorded trials take",
            "record fewer trials, fewer seconds or fewer frames a second",
        )
        posts.append(proceed(posts[-1], genotypes, terrain, np.int32(stride * steps)))
    num_posts = len(posts)
    walks: Any = jax.tree.map(lambda *leaves: np.concatenate(leaves), *posts)
    rows = np.tile(terrain.row, num_posts)
    repeated = jax.tree.map(lambda leaf: np.concatenate([leaf] * num_posts), genotypes)
    frames = [walks]
    for _ in range(stride - 1):
        walks = proceed(walks, repeated, terrain._replace(row=rows), np.int32(steps))
        frames.append(walks)

    walks = jax.tree.map(lambda *leaves: _in_order(leaves, num_posts, num_frames), *frames)
    ended = np.flatnonzero(walks.state.done.all(axis=1))
    if ended.size:
        walks = jax.tree.map(lambda leaf: leaf[: ended[0] + 1], walks)
    time = (walks.state.num_steps * env.timestep).astype(np.float32)
    return Recording(time, walks.state.done, walks.state, walks.memory)


@dataclasses.dataclass(frozen=True)
class _Walker:
    """A body and what drives it: the settings of the two functions that engines compile."""

    env: Environment
    controller: Controller

    def begin(self, genotype: Any, ground: Any) -> Walk:
        """Returns the start of a trial."""
        return start(self.env, self.controller, genotype, ground)

    def proceed(self, walk: Walk, genotype: Any, ground: Any, steps: Any) -> Walk:
        """Returns what a number of steps makes of a trial."""

        def walking(at: tuple[Any, Walk]) -> Any:
            return (at[0] < steps) & ~at[1].state.done

        def step(at: tuple[Any, Walk]) -> tuple[Any, Walk]:
            return at[0] + 1, advance(self.env, self.controller, genotype, ground, at[1])

        return jax.lax.while_loop(walking, step, (jnp.zeros((), jnp.int32), walk))[1]


@functools.lru_cache(maxsize=8)
def _beginning(walker: _Walker, terrain_type: Any, engine: str) -> Any:
    return _vmap(walker.begin, engine, (0, terrain_type(heights=None, row=0)), None)


@functools.lru_cache(maxsize=8)
def _proceeding(walker: _Walker, terrain_type: Any, engine: str, tree: Any) -> Any:
    axes = (0, 0, terrain_type(heights=None, row=0), None)
    return _vmap(walker.proceed, engine, axes, jax.tree.unflatten(tree, range(tree.num_leaves)))


def _vmap(function: Callable[..., Any], engine: str, in_axes: Any, results: Any) -> Any:
    """Returns a function for many walkers; `results` is a tree like what it returns."""
    if engine == "lanes":
        return lanes.vmap(function, in_axes, results=results)
    return (lanes.xla_vmap if engine == "lanes-xla" else mjx.vmap)(function, in_axes)


def _in_order(leaves: tuple[Any, ...], num_posts: int, num_frames: int) -> Any:
    """Returns frames [post and walker, ...] as one array [frame, walker, ...]."""
    frames = np.stack([np.asarray(leaf) for leaf in leaves])
    between, _, *shape = frames.shape
    frames = frames.reshape(between, num_posts, -1, *shape).swapaxes(0, 1)
    return frames.reshape(between * num_posts, -1, *shape)[:num_frames]


def _steps_per_frame(env: Environment, duration: float, frames_per_second: float) -> int:
    if not 0.0 < frames_per_second <= 1.001 / env.timestep:
        raise ValueError(
            f"frames_per_second must be above 0 and at most {1.0 / env.timestep:g}, one a step, "
            f"got {frames_per_second}"
        )
    if not duration * frames_per_second >= 0.999:
        raise ValueError(f"duration must be a frame at least, got {duration} s")
    return max(1, round(1.0 / (frames_per_second * env.timestep)))


def _laid_out(terrain: Any) -> Any:
    """Returns terrain whose table is filled up to a power of two, since engines compile for it."""
    heights = np.asarray(terrain.heights)
    missing = (1 << (len(heights) - 1).bit_length()) - len(heights)
    filled = np.concatenate([heights, np.repeat(heights[:1], missing, axis=0)])
    return terrain._replace(heights=filled, row=np.asarray(terrain.row))


def skeleton(env: Planar7, qpos: Float[np.ndarray, "frame 9"]) -> Float[np.ndarray, "frame 2 7 2"]:
    """Returns where the planar body's joints are, in one walker's frames.

    For each leg, x and z of shoulder, hip, knee, ankle, heel, toe and ankle again, m.
    """
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


def spatial_skeleton(
    env: Flame, qpos: Float[np.ndarray, "frame 15"]
) -> Float[np.ndarray, "frame 2 8 3"]:
    """Returns where the spatial body's joints are, in one walker's frames.

    For each leg, x, y and z of the torso's top, its middle between the hips, hip, knee, ankle,
    heel, toe and ankle again, m.
    """
    model = env.model.mujoco
    data = mujoco.MjData(model)
    top = np.array([0.0, 0.0, TORSO_HEIGHT])
    figures = np.zeros((len(qpos), 2, 8, 3))
    for frame, coordinates in enumerate(qpos):
        data.qpos[:] = coordinates[COORDINATE]
        mujoco.mj_kinematics(model, data)
        torso = data.body("torso")
        head = torso.xpos + torso.xmat.reshape(3, 3) @ top
        for leg, name in enumerate(LEGS):
            links = [data.body(f"{link}_{name}").xpos for link in ("thigh", "shank", "foot")]
            heel, toe = (
                np.mean([data.site(f"{end}_{side}_{name}").xpos for side in ("in", "out")], axis=0)
                for end in ("heel", "toe")
            )
            figures[frame, leg] = [head, torso.xpos, *links, heel, toe, links[2]]
    return figures


def _turned(pitch: Float[np.ndarray, " frame"], x: float, z: float) -> Any:
    """Returns a vector of a link that is pitched forward, world x and z."""
    sin, cos = np.sin(pitch), np.cos(pitch)
    return np.stack([cos * x + sin * z, cos * z - sin * x], axis=-1)
