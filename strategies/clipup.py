"""ClipUp: gradient descent with momentum, of normalised gradients, at a speed that is bounded.

Toklu, Liskowski & Srivastava (2020), "ClipUp: a simple and powerful optimizer for
distribution-based policy evolution", https://arxiv.org/abs/2008.02387, algorithm 1. Steps are as
long as the settings say, whatever the size of fitness or of its estimated gradient.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float

from mjxwalk.strategies import checks
from mjxwalk.strategies.base import FloatTree, ScalarLike

MOMENTUM = 0.9  # Toklu et al. (2020), section 4
MAX_SPEED = 0.15  # that of ClipUp in nnaisense/pgpelib
# Toklu et al. (2020), section 4: the learning rate of the centre, and the maximum speed over the
# radius of the first population.
LEARNING_RATE_PER_SPEED = 1 / 2
SPEED_PER_RADIUS = 1 / 15


class ClipUpState(NamedTuple):
    """State between steps.

    Attributes:
      velocity: the last step, in the shape of what is optimised.
    """

    velocity: FloatTree


def clipup(
    learning_rate: ScalarLike, max_speed: ScalarLike, momentum: ScalarLike = MOMENTUM
) -> optax.GradientTransformation:
    """Returns ClipUp, Toklu et al. (2020), algorithm 1; it goes downhill, as optax does.

    A gradient of zero, which has no direction, adds nothing to the velocity.

    Args:
      learning_rate: length of what a gradient adds to the velocity.
      max_speed: greatest length of the velocity, and so of a step.
      momentum: share of the velocity that is kept; below 1.

    Raises:
      ValueError: a setting is out of its range.
    """
    checks.check_numbers("learning_rate", learning_rate, above=0.0)
    checks.check_numbers("max_speed", max_speed, above=0.0)
    checks.check_numbers("momentum", momentum, minimum=0.0, maximum=1.0)

    def init(params: Any) -> ClipUpState:
        return ClipUpState(jax.tree.map(jnp.zeros_like, params))

    def update(updates: Any, state: Any, params: Any = None) -> tuple[Any, ClipUpState]:
        del params
        _, direction = _length_and_direction(updates)
        pushed = jax.tree.map(
            lambda before, downhill: momentum * before - learning_rate * downhill,
            state.velocity,
            direction,
        )
        speed, direction = _length_and_direction(pushed)
        clipped = jax.tree.map(
            lambda free, unit: jnp.where(speed > max_speed, max_speed * unit, free),
            pushed,
            direction,
        )
        return clipped, ClipUpState(clipped)

    return optax.GradientTransformation(init, update)


def _length_and_direction(tree: Any) -> tuple[Float[Array, ""], Any]:
    """Returns the length of all numbers as one vector, and the tree over it; 0 stays 0."""
    # Scaled first, so that no square leaves float32.
    largest = jnp.max(jnp.stack([jnp.max(jnp.abs(leaf)) for leaf in jax.tree.leaves(tree)]))
    scale = jnp.where(largest > 0, largest, 1.0)
    scaled = jax.tree.map(lambda leaf: leaf / scale, tree)
    length = jnp.sqrt(sum(jnp.sum(leaf**2) for leaf in jax.tree.leaves(scaled)))
    unit = jnp.where(length > 0, length, 1.0)
    return length * scale, jax.tree.map(lambda leaf: leaf / unit, scaled)
