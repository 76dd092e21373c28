"""OpenAI's evolution strategy: a gradient estimated from mirrored noise, and any optimiser.

Salimans, Ho, Chen, Sidor & Sutskever (2017), "Evolution strategies as a scalable alternative to
reinforcement learning", https://arxiv.org/abs/1703.03864, algorithm 1 with the mirrored sampling
and the ranks of section 2.
"""

import functools
from typing import Any, NamedTuple

import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, Int

from mjxwalk.strategies import checks, gradients, vectors
from mjxwalk.strategies.base import Genotype, ScalarLike, Strategy, Tree
from mjxwalk.strategies.gradients import LEARNING_RATE, Optimizer, OptimizerSettings
from mjxwalk.strategies.metrics import SearchMetrics
from mjxwalk.strategies.normal_search import normal_search
from mjxwalk.strategies.ranks import centred_ranks


class OpenAIESState(NamedTuple):
    """State between generations.

    Attributes:
      mean: what the population is drawn around, as one vector; see `vectors.unflatten`.
      optimizer_state: optax's.
      template: genotype that the search started from.
      generation: number of the generation to be evaluated next.
    """

    mean: Float[Array, " dim"]
    optimizer_state: Any
    template: Genotype
    generation: Int[Array, ""]


def openai_es(
    *,
    population_size: int,
    sigma: Tree,
    optimizer: Optimizer = LEARNING_RATE,
    learning_rate: ScalarLike | None = None,
    momentum: ScalarLike | None = None,
    max_speed: ScalarLike | None = None,
    weight_decay: ScalarLike = 0.0,
) -> Strategy[OpenAIESState, SearchMetrics]:
    """Returns the evolution strategy of Salimans et al. (2017), algorithm 1.

    Args:
      population_size: genotypes in a generation; even, because noise is mirrored.
      sigma: standard deviation of the noise, in units of the weights; one value, or a pytree
        prefix of the template.
      optimizer: turns the gradient estimate into a step of the mean; a number is the learning rate
        of Adam, a name is "adam", "sgd" or "clipup".
      learning_rate: of an optimiser by name; of ClipUp, None for half of its maximum speed.
      momentum: of "sgd" and "clipup".
      max_speed: of "clipup": length of the longest step.
      weight_decay: pull of the mean to 0, see `gradients.decayed`; the authors' own l2coeff.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_numbers("weight_decay", weight_decay, minimum=0.0)
    chosen = OptimizerSettings(learning_rate, momentum, max_speed)
    optimizer = gradients.make_optimizer(optimizer, chosen)
    return normal_search(
        population_size=population_size,
        sigma=sigma,
        init=functools.partial(_init, optimizer),
        tell=functools.partial(_tell, optimizer, sigma, weight_decay),
        mirrored=True,
    )


def _init(
    optimizer: optax.GradientTransformation, template: Genotype, deviations: Float[Array, " dim"]
) -> OpenAIESState:
    del deviations
    mean = vectors.flatten(template)
    return OpenAIESState(
        mean=mean,
        optimizer_state=optimizer.init(mean),
        template=template,
        generation=jnp.zeros((), jnp.int32),
    )


def _tell(
    optimizer: optax.GradientTransformation,
    sigma: Tree,
    weight_decay: ScalarLike,
    genotypes: Float[Array, "pop dim"],
    fitness: Float[Array, " pop"],
    state: OpenAIESState,
) -> OpenAIESState:
    deviations = vectors.spread("sigma", sigma, state.template)
    worth = centred_ranks(fitness).astype(state.mean.dtype)
    steps = genotypes - state.mean
    # The noise is what was evaluated, also where someone has changed it between ask and tell.
    gradient = worth @ steps / (fitness.size * deviations**2)
    gradient = gradients.decayed(gradient, weight_decay, state.mean, 1 / deviations)
    mean, optimizer_state = gradients.ascend(optimizer, gradient, state.optimizer_state, state.mean)
    return state._replace(
        mean=mean, optimizer_state=optimizer_state, generation=state.generation + 1
    )
