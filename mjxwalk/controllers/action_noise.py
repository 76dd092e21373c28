"""Noise on the actions of a policy, which makes walkers evolve that bear it.

Salimans et al. (2017), "Evolution strategies as a scalable alternative to reinforcement learning",
arXiv:1703.03864, evolve with it. It is a function of the trial and of the action's number in it, so
that a trial can be repeated, from any place on and by any engine.
"""

import math
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, UInt32

from mjxwalk.strategies.threefry import hash_words

BITS = 24  # that float32 tells apart


def noisy(action: Any, deviation: float, seed: UInt32[Array, ""], turn: Int[Array, ""]) -> Any:
    """Returns an action with normal noise on each of its numbers.

    Args:
      action: a number from -1 to 1 for each motor.
      deviation: standard deviation of the noise.
      seed: of the trial.
      turn: how many actions there were before in the trial.

    Raises:
      ValueError: the action is none of numbers.
    """
    if isinstance(action, tuple):
        raise ValueError(
            "action_noise must be 0 where a controller's actions are not numbers from -1 to 1, got "
            f"{deviation:g}"
        )
    action = jnp.asarray(action)
    return action + deviation * normal(seed, turn, action.shape[0]).astype(action.dtype)


def normal(seed: UInt32[Array, ""], turn: Int[Array, ""], num: int) -> Float[Array, " num"]:
    """Returns independent numbers from the standard normal distribution (Box & Muller 1958).

    Args:
      seed: of the trial.
      turn: how many actions there were before in the trial.
      num: how many numbers.
    """
    place = np.arange(num, dtype=np.uint32)
    turns = jnp.full(num, turn).astype(jnp.uint32)
    seed = jnp.asarray(seed)
    first, second = hash_words(seed, jnp.zeros_like(seed), turns, place)
    drop = np.uint32(32 - BITS)
    # Half a step above 0, whose logarithm is infinite.
    share = ((first >> drop).astype(jnp.float32) + np.float32(0.5)) * np.float32(2.0**-BITS)
    angle = (second >> drop).astype(jnp.float32) * np.float32(2.0 * math.pi * 2.0**-BITS)
    return jnp.sqrt(-2.0 * jnp.log(share)) * jnp.cos(angle)
