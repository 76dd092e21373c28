"""Following an estimated gradient with an optimiser of optax."""

from typing import Any, TypeAlias

import jax.numpy as jnp
import optax
from jaxtyping import Array, Float

from mjxwalk.strategies import checks
from mjxwalk.strategies.base import ScalarLike

Optimizer: TypeAlias = optax.GradientTransformation | ScalarLike


def make_optimizer(optimizer: Optimizer) -> optax.GradientTransformation:
    """Returns the optimiser; a number is the learning rate of Adam.

    Raises:
      ValueError: the number is not positive.
    """
    if isinstance(optimizer, optax.GradientTransformation):
        return optimizer
    checks.check_numbers("optimizer", optimizer, above=0.0)
    return optax.adam(optimizer)


def ascend(
    optimizer: optax.GradientTransformation,
    gradient: Float[Array, " dim"],
    optimizer_state: Any,
    mean: Float[Array, " dim"],
) -> tuple[Float[Array, " dim"], Any]:
    """Returns the mean after one step uphill, and the optimiser's next state."""
    # optax goes downhill.
    updates, optimizer_state = optimizer.update(-gradient, optimizer_state, mean)
    return mean + jnp.asarray(updates), optimizer_state
