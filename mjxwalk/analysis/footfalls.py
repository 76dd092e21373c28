"""What the analysis needs of a recording, for any body: contacts, feet, and angles by role."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Bool, Float

from mjxwalk.analysis.strides import SHORTEST_PHASE, debounced, stance_leg
from mjxwalk.replay import Recording
from mjxwalk.rollout import Environment


class Footfalls(NamedTuple):
    """When and where one walker's feet touch the ground, up to the end of its trial.

    Attributes:
      time: s.
      contact: whether each foot touches the ground, without chatter; left and right of two.
      ankle_x: where each ankle is, m.
      left_stance: of two, whether the left leg is the stance leg; of more, never.
    """

    time: Float[np.ndarray, " frame"]
    contact: Bool[np.ndarray, "frame leg"]
    ankle_x: Float[np.ndarray, "frame leg"]
    left_stance: Bool[np.ndarray, " frame"]


def observe(recording: Recording, env: Environment) -> Any:
    """Returns what the walkers sensed, leaves [frame, walker, ...]; numpy."""
    return jax.tree.map(np.asarray, _over_frames(env.observe)(recording.states))


def find_footfalls(
    recording: Recording, observations: Any, *, shortest: float = SHORTEST_PHASE
) -> list[Footfalls]:
    """Returns every walker's footfalls.

    Args:
      recording: of trials.
      observations: from `observe`; of them contacts and ankles are read.
      shortest: see `debounced`, s.
    """
    found: list[Footfalls] = []
    hip_x = recording.states.qpos[:, :, :1]
    for walker in range(recording.done.shape[1]):
        # The frame in which a trial has ended is still its own; those after repeat it.
        num = 1 + int(np.argmax(recording.done[:, walker]))
        if not recording.done[-1, walker]:
            num = len(recording.done)
        time = recording.time[:num, walker].astype(np.float64)
        ankle_x = (hip_x + observations.ankle_x)[:num, walker].astype(np.float64)
        contact = debounced(observations.contact[:num, walker], time, shortest)
        has_two = contact.shape[1] == 2
        left = stance_leg(contact, ankle_x) if has_two else np.zeros(len(time), bool)
        found.append(Footfalls(time, contact, ankle_x, left))
    return found


def role_angles(
    observations: Any,
    footfalls: list[Footfalls],
    sense: Callable[[Any, Any], Any],
) -> Float[np.ndarray, "frame walker angle"]:
    """Returns angles by role, as the controller senses them, rad.

    Args:
      observations: from `observe`.
      footfalls: of all walkers; they say which leg is the stance leg.
      sense: of the controller: from an observation, and whether the left leg is the stance leg, to
        senses with an `angle`.
    """
    frames = len(observations.time)
    left = [np.pad(each.left_stance, (0, frames - len(each.time)), "edge") for each in footfalls]
    return np.asarray(_over_frames(sense)(observations, np.stack(left, axis=1)).angle)


@functools.lru_cache(maxsize=8)
def _over_frames(function: Callable[..., Any]) -> Callable[..., Any]:
    """Returns a function of one walker in one frame for all frames and walkers."""
    return jax.jit(jax.vmap(jax.vmap(function)))
