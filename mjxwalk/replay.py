"""Walks walkers again and records what happens, frame by frame."""

import dataclasses
import functools
import math
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from mjxwalk import budget, engines
from mjxwalk.engines.pinning import pinned
from mjxwalk.envs import TRIAL_AXES, Trial
from mjxwalk.rollout import Controller, Environment, Walk, advance, start


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
    given: Trial,
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
      given: each walker's trial, from `Trials.given`.
      duration: s.
      frames_per_second: in the trials' time; frames fall on whole steps of the physics.
      engine: as `mjxwalk.engines.choose` knows it.

    Raises:
      ValueError: there is no such engine, the frame rate is not above zero or exceeds the physics'
        own, or the duration is below a frame.
    """
    steps = _steps_per_frame(env, duration, frames_per_second)
    num_frames = 1 + round(duration / (steps * env.timestep))
    given = _laid_out(given)
    walker, engine = _Walker(env, controller), engines.choose(engine).name
    genotypes = jax.tree.map(np.asarray, genotypes)
    first = _beginning(walker, engine)(genotypes, given)
    proceed = _proceeding(walker, engine, jax.tree.structure(first))

    # A call costs a thousandth of a second, however many walkers it moves and however short. So
    # walk to every 80th frame first, say, and then from all of these at once to those between.
    stride = math.isqrt(num_frames)
    posts = [first]
    frame = sum(np.asarray(leaf).nbytes for leaf in jax.tree.leaves(first))
    while stride * len(posts) < num_frames and not np.all(posts[-1].state.trial.done):
        budget.check(
            2.0 * frame * stride * len(posts),  # the frames, and the same in their order
            f"{len(given.ground.row):,} recorded trials take",
            "record fewer trials, fewer seconds or fewer frames a second",
        )
        posts.append(proceed(posts[-1], genotypes, given, np.int32(stride * steps)))
    num_posts = len(posts)
    walks: Any = jax.tree.map(lambda *leaves: np.concatenate(leaves), *posts)
    own = genotypes, given._replace(ground=given.ground.row)
    repeated, again = jax.tree.map(lambda leaf: np.concatenate([leaf] * num_posts), own)
    again = again._replace(ground=given.ground._replace(row=again.ground))
    frames = [walks]
    for _ in range(stride - 1):
        walks = proceed(walks, repeated, again, np.int32(steps))
        frames.append(walks)

    walks = jax.tree.map(lambda *leaves: _in_order(leaves, num_posts, num_frames), *frames)
    ended = np.flatnonzero(walks.state.trial.done.all(axis=1))
    if ended.size:
        walks = jax.tree.map(lambda leaf: leaf[: ended[0] + 1], walks)
    time = (walks.state.trial.num_steps * env.timestep).astype(np.float32)
    return Recording(time, walks.state.trial.done, walks.state, walks.memory)


@dataclasses.dataclass(frozen=True)
class _Walker:
    """A body and what drives it: the settings of the two functions that engines compile."""

    env: Environment
    controller: Controller

    def begin(self, genotype: Any, given: Trial) -> Walk:
        """Returns the start of a trial."""
        return start(self.env, self.controller, genotype, given)

    def proceed(self, walk: Walk, genotype: Any, given: Trial, steps: Any) -> Walk:
        """Returns what a number of steps makes of a trial."""

        def walking(at: tuple[Any, Walk]) -> Any:
            return (at[0] < steps) & ~at[1].state.trial.done

        def step(at: tuple[Any, Walk]) -> tuple[Any, Walk]:
            return at[0] + 1, advance(self.env, self.controller, genotype, given, at[1])

        return jax.lax.while_loop(walking, step, (jnp.zeros((), jnp.int32), walk))[1]


@functools.lru_cache(maxsize=8)
def _beginning(walker: _Walker, engine: str) -> Any:
    return engines.load(engine).vmap(walker.begin, (0, TRIAL_AXES))


@functools.lru_cache(maxsize=8)
def _proceeding(walker: _Walker, engine: str, tree: Any) -> Any:
    results = jax.tree.unflatten(tree, range(tree.num_leaves))
    return engines.load(engine).vmap(walker.proceed, (0, 0, TRIAL_AXES, None), results=results)


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


def _laid_out(given: Trial) -> Trial:
    """Returns trials whose table is filled up to a power of two, since engines compile for it."""
    given = jax.tree.map(np.asarray, given)
    num = len(given.ground.heights)
    rows = np.arange(1 << (num - 1).bit_length())
    rows[num:] = 0
    table = given.ground.heights, given.ground.course
    heights, course = jax.tree.map(lambda leaf: leaf[rows], table)
    return given._replace(ground=given.ground._replace(heights=heights, course=course))
