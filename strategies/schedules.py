"""Hyper-parameters that change from generation to generation, such as a step size annealed."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk.strategies.base import Genotype, Population, Strategy


class ScheduledState(NamedTuple):
    """State of a strategy whose hyper-parameter changes.

    Attributes:
      inner: the strategy's own state.
      generation: number of the generation to be evaluated next.
    """

    inner: Any
    generation: Int[Array, ""]


def with_schedule(
    make: Callable[[Float[Array, ""]], Strategy[Any, Any]],
    schedule: Callable[[Int[Array, ""]], Float[Array, ""]],
) -> Strategy[ScheduledState, Any]:
    """Returns a strategy made anew each generation, with the value that a schedule gives.

    As in `with_schedule(lambda sigma: openai_es(population_size=256, sigma=sigma),
    optax.cosine_decay_schedule(0.1, 500))`. What a strategy adapts itself, as CMA-ES its sigma, is
    in its state and takes its first value alone from the schedule.

    Args:
      make: a strategy with that value, which is traced; its shapes must not depend on it.
      schedule: value for a generation's number, such as one of optax.
    """
    population_size = make(jnp.asarray(schedule(jnp.zeros((), jnp.int32)))).population_size

    def current(generation: Int[Array, ""]) -> Strategy[Any, Any]:
        return make(jnp.asarray(schedule(generation)))

    def init(key: PRNGKeyArray, template: Genotype) -> ScheduledState:
        generation = jnp.zeros((), jnp.int32)
        return ScheduledState(current(generation).init(key, template), generation)

    def ask(key: PRNGKeyArray, state: ScheduledState) -> tuple[Population, ScheduledState]:
        population, inner = current(state.generation).ask(key, state.inner)
        return population, state._replace(inner=inner)

    def tell(
        key: PRNGKeyArray,
        population: Population,
        fitness: Float[Array, " pop"],
        state: ScheduledState,
    ) -> tuple[ScheduledState, Any]:
        strategy = current(state.generation)
        inner, metrics = strategy.tell(key, population, fitness, state.inner)
        return ScheduledState(inner, state.generation + 1), metrics

    return Strategy(population_size=population_size, init=init, ask=ask, tell=tell)
