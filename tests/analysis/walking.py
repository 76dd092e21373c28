"""A gait made by hand, whose strides are known exactly, as contacts and as a recording."""

from typing import Any, NamedTuple

import jax
import numpy as np

from mjxwalk.envs import Planar7
from mjxwalk.replay import Recording

FRAME = 0.01  # s
STRIDE_FRAMES = 120  # 1.2 s
STANCE_FRAMES = 72  # 60 %, so that both feet are down in 20 %
STEP = 0.6  # m


class Walk(NamedTuple):
    """Frames of one walker: time in s, contacts and places of the ankles (m), left and right."""

    time: Any
    contact: Any
    ankle_x: Any


def walk(frames: int = 600, *, stance: int = STANCE_FRAMES) -> Walk:
    """Returns walking in steps of 0.6 m, the right foot half a stride after the left."""
    time = FRAME * np.arange(frames)
    contact, ankle_x = np.zeros((frames, 2), bool), np.zeros((frames, 2))
    for foot, shift in ((0, 0), (1, STRIDE_FRAMES // 2)):
        count, phase = np.divmod(np.arange(frames) + shift, STRIDE_FRAMES)
        contact[:, foot] = phase < stance
        swing = np.clip((phase - stance) / (STRIDE_FRAMES - stance), 0.0, 1.0)
        ankle_x[:, foot] = 2 * STEP * (count + swing) - shift / STRIDE_FRAMES * 2 * STEP
    return Walk(time, contact, ankle_x)


def stand(frames: int = 600) -> Walk:
    """Returns standing, one foot ahead of the other."""
    ankle_x = np.repeat([[0.1, -0.1]], frames, axis=0)
    return Walk(FRAME * np.arange(frames), np.ones((frames, 2), bool), ankle_x)


def recording(walks: list[Walk], *, fell: list[bool], work: float = 100.0) -> Recording:
    """Returns the walks as trials of the planar body, whose hip is midway between the ankles.

    A shorter one has ended before the others. Each does `work` J, spread evenly over its frames.
    """
    frames, num = max(len(each.time) for each in walks), len(walks)
    env = Planar7()
    start = env.reset(env.level_trials().given(0))
    states: Any = jax.tree.map(lambda leaf: np.zeros((frames, num, *leaf.shape), leaf.dtype), start)
    counts = states.trial
    for place, each in enumerate(walks):
        size = len(each.time)
        hip = each.ankle_x.mean(axis=1)
        at = np.minimum(np.arange(frames), size - 1)
        states.qpos[:, place, 0] = hip[at]
        states.touching[:, place] = np.repeat(each.contact, 2, axis=1)[at]
        states.ankle_x[:, place] = (each.ankle_x - hip[:, None])[at]
        counts.work[:, place] = np.linspace(0.0, work, size)[at]
        counts.num_steps[:, place] = np.rint(each.time / env.timestep)[at]
        ended = np.arange(frames) >= size - 1
        counts.done[:, place] = ended
        counts.fell[:, place] = ended & fell[place]
    time = (counts.num_steps * env.timestep).astype(np.float32)
    return Recording(time, counts.done, states)
