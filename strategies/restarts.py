"""Restarts: a population that has not got far enough by a certain age starts anew.

Evolution of walking has a bootstrap problem: a share of first populations settles on a lunge and a
fall. Starting such a run anew costs less than waiting for it.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks
from mjxwalk.strategies.base import Genotype, Population, Strategy


class RestartState(NamedTuple):
    """State of a strategy that restarts.

    Attributes:
      inner: the strategy's own state.
      template: what it starts from.
      age: generations told since the start.
      best_fitness: highest since the start; minus infinity before the first.
      num_restarts: so far.
    """

    inner: Any
    template: Genotype
    age: Int[Array, ""]
    best_fitness: Float[Array, ""]
    num_restarts: Int[Array, ""]


def with_restarts(
    strategy: Strategy[Any, Any], *, after: int, below: float, max_age: int | None = None
) -> Strategy[RestartState, Any]:
    """Returns the strategy, started anew where its best fitness is too low at a certain age.

    Args:
      strategy: any.
      after: age at which a population is judged, in generations.
      below: fitness that the best of all these generations must reach.
      max_age: age at which every population starts anew, for evolutions that end at a goal: who has
        not reached it by then is slow; None for never.

    Raises:
      ValueError: after is not a positive count, or max_age is not above it.
    """
    checks.check_count("after", after, minimum=1)
    if max_age is not None:
        checks.check_count("max_age", max_age, minimum=after + 1)

    def start(key: PRNGKeyArray, template: Genotype, num_restarts: Int[Array, ""]) -> RestartState:
        worst = jnp.full((), -jnp.inf, float)
        inner = strategy.init(key, template)
        return RestartState(inner, template, jnp.zeros((), jnp.int32), worst, num_restarts)

    def init(key: PRNGKeyArray, template: Genotype) -> RestartState:
        return start(key, template, jnp.zeros((), jnp.int32))

    def ask(key: PRNGKeyArray, state: RestartState) -> tuple[Population, RestartState]:
        population, inner = strategy.ask(key, state.inner)
        return population, state._replace(inner=inner)

    def tell(
        key: PRNGKeyArray,
        population: Population,
        fitness: Float[Array, " pop"],
        state: RestartState,
    ) -> tuple[RestartState, Any]:
        key_tell, key_start = jax.random.split(key)
        inner, metrics = strategy.tell(key_tell, population, fitness, state.inner)
        best = jnp.max(jnp.where(jnp.isnan(fitness), -jnp.inf, fitness))
        best = jnp.maximum(state.best_fitness, best.astype(state.best_fitness.dtype))
        going_on = state._replace(inner=inner, age=state.age + 1, best_fitness=best)
        stuck = (going_on.age == after) & (best < below)
        if max_age is not None:
            stuck |= going_on.age == max_age
        return jax.lax.cond(
            stuck,
            lambda key: start(key, state.template, state.num_restarts + 1),
            lambda key: going_on,
            key_start,
        ), metrics

    return Strategy(population_size=strategy.population_size, init=init, ask=ask, tell=tell)
