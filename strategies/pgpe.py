"""Policy gradients with parameter-based exploration: a gradient for means and for step sizes.

Sehnke, Osendorfer, Rueckstiess, Graves, Peters & Schmidhuber (2010), "Parameter-exploring policy
gradients", Neural Networks 23(4):551-559, doi 10.1016/j.neunet.2009.12.004, section 3.3: symmetric
sampling. Ranks in place of rewards, the bound on a step size's change, and the first step sizes by
their radius are those of Toklu, Liskowski & Srivastava (2020), "ClipUp",
https://arxiv.org/abs/2008.02387, who follow the gradient with the optimiser `clipup`.
"""

import functools
import math
from typing import Any, NamedTuple

import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, Int

from mjxwalk.strategies import checks, gradients, vectors
from mjxwalk.strategies.base import Genotype, ScalarLike, Strategy, Tree
from mjxwalk.strategies.clipup import SPEED_PER_RADIUS
from mjxwalk.strategies.gradients import LEARNING_RATE, Optimizer, OptimizerSettings
from mjxwalk.strategies.metrics import SearchMetrics
from mjxwalk.strategies.normal_search import normal_search
from mjxwalk.strategies.ranks import centred_ranks

SIGMA_LEARNING_RATE = 0.1  # Toklu et al. (2020): stdev_learning_rate of nnaisense/pgpelib
# Of a step size in a generation, its share; Toklu et al. (2020): stdev_max_change of pgpelib.
LARGEST_CHANGE = 0.2


class PGPEState(NamedTuple):
    """State between generations.

    Attributes:
      mean: what the population is drawn around, as one vector; see `vectors.unflatten`.
      sigma: standard deviation of each weight.
      optimizer_state: optax's, for the mean.
      template: genotype that the search started from.
      generation: number of the generation to be evaluated next.
    """

    mean: Float[Array, " dim"]
    sigma: Float[Array, " dim"]
    optimizer_state: Any
    template: Genotype
    generation: Int[Array, ""]


class _Rates(NamedTuple):
    """Checked arguments of `pgpe` that a step needs."""

    sigma_learning_rate: ScalarLike
    largest_change: ScalarLike
    weight_decay: ScalarLike


def pgpe(
    *,
    population_size: int,
    sigma: Tree | None = None,
    radius: ScalarLike | None = None,
    optimizer: Optimizer = LEARNING_RATE,
    learning_rate: ScalarLike | None = None,
    momentum: ScalarLike | None = None,
    max_speed: ScalarLike | None = None,
    weight_decay: ScalarLike = 0.0,
    sigma_learning_rate: ScalarLike = SIGMA_LEARNING_RATE,
    largest_change: ScalarLike = LARGEST_CHANGE,
) -> Strategy[PGPEState, SearchMetrics]:
    """Returns PGPE with symmetric sampling, Sehnke et al. (2010), section 3.3.

    Args:
      population_size: genotypes in a generation; even, because noise is mirrored.
      sigma: standard deviation of generation 0, in units of the weights; one value, or a pytree
        prefix of the template.
      radius: length of the vector of all standard deviations of generation 0, all the same; where
        it is given, `sigma` does not count.
      optimizer: turns the gradient estimate into a step of the mean; a number is the learning rate
        of Adam, a name is "adam", "sgd" or "clipup".
      learning_rate: of an optimiser by name; of ClipUp, None for half of its maximum speed.
      momentum: of "sgd" and "clipup".
      max_speed: of "clipup": length of the longest step; None for a fifteenth of the radius, where
        one is given.
      weight_decay: pull of the mean to 0, see `gradients.decayed`.
      sigma_learning_rate: step of the step sizes along their gradient.
      largest_change: share of a step size by which it may change in a generation; below 1.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_numbers("sigma_learning_rate", sigma_learning_rate, minimum=0.0)
    checks.check_numbers("largest_change", largest_change, minimum=0.0, maximum=1.0)
    checks.check_numbers("weight_decay", weight_decay, minimum=0.0)
    if radius is None and sigma is None:
        raise ValueError("pgpe needs a value for sigma or for radius")
    if radius is not None:
        checks.check_numbers("radius", radius, above=0.0)
        if isinstance(optimizer, str) and optimizer == "clipup" and max_speed is None:
            max_speed = SPEED_PER_RADIUS * radius
    chosen = OptimizerSettings(learning_rate, momentum, max_speed)
    optimizer = gradients.make_optimizer(optimizer, chosen)
    rates = _Rates(sigma_learning_rate, largest_change, weight_decay)
    return normal_search(
        population_size=population_size,
        sigma=1.0 if radius is not None else sigma,
        init=functools.partial(_init, optimizer, radius),
        deviations=lambda state: state.sigma,
        tell=functools.partial(_tell, optimizer, rates),
        mirrored=True,
    )


def _init(
    optimizer: optax.GradientTransformation,
    radius: ScalarLike | None,
    template: Genotype,
    deviations: Float[Array, " dim"],
) -> PGPEState:
    mean = vectors.flatten(template)
    if radius is not None:
        deviations = deviations * (radius / math.sqrt(mean.size))
    return PGPEState(
        mean=mean,
        sigma=deviations,
        optimizer_state=optimizer.init(mean),
        template=template,
        generation=jnp.zeros((), jnp.int32),
    )


def _tell(
    optimizer: optax.GradientTransformation,
    rates: _Rates,
    genotypes: Float[Array, "pop dim"],
    fitness: Float[Array, " pop"],
    state: PGPEState,
) -> PGPEState:
    num_pairs = fitness.size // 2
    worth = centred_ranks(fitness).astype(state.mean.dtype)
    plus, minus = worth[:num_pairs], worth[num_pairs:]
    steps = (genotypes[:num_pairs] - genotypes[num_pairs:]) / 2
    # Both gradients times sigma squared, and so in units of the weights, as the paper takes them;
    # ranks are centred, so that the paper's baseline is 0.
    gradient = (plus - minus) / 2 @ steps / num_pairs
    gradient = gradients.decayed(gradient, rates.weight_decay, state.mean, state.sigma)
    sigma_gradient = (plus + minus) / 2 @ ((steps / state.sigma) ** 2 - 1) / num_pairs
    mean, optimizer_state = gradients.ascend(optimizer, gradient, state.optimizer_state, state.mean)
    change = rates.sigma_learning_rate * sigma_gradient
    change = jnp.clip(change, -rates.largest_change, rates.largest_change)
    return state._replace(
        mean=mean,
        sigma=vectors.bound_sigma(state.sigma * (1 + change)),
        optimizer_state=optimizer_state,
        generation=state.generation + 1,
    )
