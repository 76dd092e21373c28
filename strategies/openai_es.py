"""OpenAI's evolution strategy: a gradient estimated from mirrored noise, and any optimiser.

Salimans, Ho, Chen, Sidor & Sutskever (2017), "Evolution strategies as a scalable alternative to
reinforcement learning", https://arxiv.org/abs/1703.03864, algorithm 1 with the mirrored sampling
and the ranks of section 2.
"""

import functools
from typing import Any, NamedTuple

import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks, gradients, vectors
from mjxwalk.strategies.base import Genotype, Strategy, Tree
from mjxwalk.strategies.gradients import Optimizer
from mjxwalk.strategies.metrics import SearchMetrics, measure_search
from mjxwalk.strategies.ranks import centred_ranks

LEARNING_RATE = (
    0.01  # of Adam, as in configurations/humanoid.json of openai/evolution-strategies-starter
)


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


class _Settings(NamedTuple):
    """Checked arguments of `openai_es`."""

    population_size: int
    sigma: Tree
    optimizer: optax.GradientTransformation


def openai_es(
    *, population_size: int, sigma: Tree, optimizer: Optimizer = LEARNING_RATE
) -> Strategy[OpenAIESState, SearchMetrics]:
    """Returns the evolution strategy of Salimans et al. (2017), algorithm 1.

    Args:
      population_size: genotypes in a generation; even, because noise is mirrored.
      sigma: standard deviation of the noise, in units of the weights; one value, or a pytree
        prefix of the template.
      optimizer: turns the gradient estimate into a step of the mean; a number is the learning rate
        of Adam.

    Raises:
      ValueError: a setting is out of its range, or, from `init`, does not fit the template.
    """
    checks.check_even("population_size", population_size)
    checks.check_numbers("sigma", sigma, above=0.0)
    settings = _Settings(population_size, sigma, gradients.make_optimizer(optimizer))
    return vectors.over_vectors(
        population_size=population_size,
        init=functools.partial(_init, settings),
        ask=functools.partial(_ask, settings),
        tell=functools.partial(_tell, settings),
    )


def _init(settings: _Settings, template: Genotype) -> OpenAIESState:
    vectors.spread("sigma", settings.sigma, template)  # to refuse what does not fit
    mean = vectors.flatten(template)
    return OpenAIESState(
        mean=mean,
        optimizer_state=settings.optimizer.init(mean),
        template=template,
        generation=jnp.zeros((), jnp.int32),
    )


def _ask(settings: _Settings, key: PRNGKeyArray, state: OpenAIESState) -> Float[Array, "pop dim"]:
    sigma = vectors.spread("sigma", settings.sigma, state.template)
    noise = vectors.mirrored_normals(key, settings.population_size, state.mean)
    return state.mean + sigma * noise


def _tell(
    settings: _Settings,
    genotypes: Float[Array, "pop dim"],
    fitness: Float[Array, " pop"],
    state: OpenAIESState,
) -> tuple[OpenAIESState, SearchMetrics]:
    sigma = vectors.spread("sigma", settings.sigma, state.template)
    worth = centred_ranks(fitness).astype(state.mean.dtype)
    steps = genotypes - state.mean
    # The noise is what was evaluated, also where someone has changed it between ask and tell.
    gradient = worth @ steps / (settings.population_size * sigma**2)
    mean, optimizer_state = gradients.ascend(
        settings.optimizer, gradient, state.optimizer_state, state.mean
    )
    new_state = state._replace(
        mean=mean, optimizer_state=optimizer_state, generation=state.generation + 1
    )
    return new_state, measure_search(fitness, sigma)
