"""Following an estimated gradient with an optimiser: one of optax, or one by name."""

from typing import Any, NamedTuple, TypeAlias

import jax.numpy as jnp
import optax
from jaxtyping import Array, Float

from mjxwalk.errors import near
from mjxwalk.strategies import checks
from mjxwalk.strategies.base import ScalarLike
from mjxwalk.strategies.clipup import LEARNING_RATE_PER_SPEED, MAX_SPEED, MOMENTUM, clipup

Optimizer: TypeAlias = optax.GradientTransformation | ScalarLike | str
LEARNING_RATE = (
    0.01  # of Adam, as in configurations/humanoid.json of openai/evolution-strategies-starter
)
SETTINGS = {  # that each optimiser takes by name
    "adam": ("learning_rate",),
    "sgd": ("learning_rate", "momentum"),
    "clipup": ("learning_rate", "momentum", "max_speed"),
}


class OptimizerSettings(NamedTuple):
    """Settings of an optimiser by name; None for the usual ones.

    Attributes:
      learning_rate: of Adam and of gradient descent; of ClipUp half of its maximum speed.
      momentum: of gradient descent and of ClipUp.
      max_speed: of ClipUp.
    """

    learning_rate: ScalarLike | None = None
    momentum: ScalarLike | None = None
    max_speed: ScalarLike | None = None


def make_optimizer(
    optimizer: Optimizer, settings: OptimizerSettings | None = None
) -> optax.GradientTransformation:
    """Returns the optimiser; a number is the learning rate of Adam.

    Args:
      optimizer: optax's, a number, or "adam", "sgd" (with momentum) or "clipup".
      settings: of an optimiser by name.

    Raises:
      ValueError: the name is unknown, a number is out of its range, or a setting is given that the
        optimiser does not have.
    """
    settings = settings or OptimizerSettings()
    given = {name: value for name, value in settings._asdict().items() if value is not None}
    if not isinstance(optimizer, str):
        if given:
            raise ValueError(
                f"{' and '.join(given)} must be null unless optimizer is a name, one of "
                f"{', '.join(SETTINGS)}; optimizer is {optimizer!r}"
            )
        if isinstance(optimizer, optax.GradientTransformation):
            return optimizer
        checks.check_numbers("optimizer", optimizer, above=0.0)
        return optax.adam(optimizer)
    if optimizer not in SETTINGS:
        raise ValueError(
            f"optimizer must be a number, the learning rate of Adam, or a name, got {optimizer!r}"
            f"{near(optimizer, SETTINGS)}"
        )
    for name in given:
        if name not in SETTINGS[optimizer]:
            raise ValueError(
                f"optimizer {optimizer} has no {name}{near(name, SETTINGS[optimizer])}"
            )
    return _by_name(optimizer, settings)


def _by_name(name: str, settings: OptimizerSettings) -> optax.GradientTransformation:
    momentum = MOMENTUM if settings.momentum is None else settings.momentum
    if name == "clipup":
        speed = MAX_SPEED if settings.max_speed is None else settings.max_speed
        checks.check_numbers("max_speed", speed, above=0.0)
        usual = LEARNING_RATE_PER_SPEED * speed
        rate = usual if settings.learning_rate is None else settings.learning_rate
        return clipup(rate, speed, momentum)
    rate = LEARNING_RATE if settings.learning_rate is None else settings.learning_rate
    checks.check_numbers("learning_rate", rate, above=0.0)
    checks.check_numbers("momentum", momentum, minimum=0.0, maximum=1.0)
    return optax.adam(rate) if name == "adam" else optax.sgd(rate, momentum=momentum)


def decayed(
    gradient: Float[Array, " dim"],
    weight_decay: ScalarLike,
    mean: Float[Array, " dim"],
    scale: Float[Array, " dim"],
) -> Float[Array, " dim"]:
    """Returns a gradient that also pulls the mean to 0: less `weight_decay * mean * scale`.

    That is L2 regularisation as in es_distributed/es.py of openai/evolution-strategies-starter: the
    optimiser is given the sum of both, so that what it makes of a gradient it makes of the pull.

    Args:
      gradient: uphill.
      weight_decay: the starter's l2coeff, for gradients of ranks in units of the noise; 0 leaves
        the gradient as it is, to the bit.
      mean: where the gradient is.
      scale: what the gradient has been multiplied by since it was in those units.
    """
    if isinstance(weight_decay, int | float) and weight_decay == 0:
        return gradient
    return gradient - weight_decay * mean * scale


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
