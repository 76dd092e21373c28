"""Statistics of what policies observe, and whitening by them: version 2 of augmented random search.

Mania, Guy & Recht (2018), "Simple random search of static linear policies is competitive for
reinforcement learning", https://arxiv.org/abs/1803.07055, algorithm 1, V2: policies see each
observation minus the mean of all since the start, over their standard deviation. Statistics of
parts are merged as by Chan, Golub & LeVeque (1983), "Algorithms for computing the sample variance",
The American Statistician 37(3):242-247, doi 10.1080/00031305.1983.10483115.

This is for loops and rollouts of your own; experiments gather theirs with `controller.normalise`,
see `mjxwalk.controllers.normalisation`. A rollout keeps `Statistics` in its carry and `add`s to it;
`merge_all` over a population is what `tell` takes.
"""

import dataclasses
from typing import Any, NamedTuple, Protocol, runtime_checkable

import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk.strategies.base import Ask, Genotype, Population, Strategy

SMALLEST_DEVIATION = 1e-4  # ours: what varies less, as a sensor that is at rest, is not blown up


class Statistics(NamedTuple):
    """Number, mean and sum of squared differences from the mean of observations.

    Attributes:
      num: how many, as a float, since there may be more than an int32 holds.
      mean: of each number observed.
      squares: sum of the squared differences.
    """

    num: Float[Array, "*part"]
    mean: Float[Array, "*part obs"]
    squares: Float[Array, "*part obs"]


def nothing(num_observed: int) -> Statistics:
    """Returns the statistics of no observation."""
    zeros = jnp.zeros(num_observed, float)
    return Statistics(jnp.zeros((), float), zeros, zeros)


def add(statistics: Statistics, observation: Float[Array, " obs"]) -> Statistics:
    """Returns the statistics with one observation more."""
    one = jnp.ones((), float)
    return merge(statistics, Statistics(one, observation, jnp.zeros_like(observation)))


def merge(first: Statistics, second: Statistics) -> Statistics:
    """Returns the statistics of the observations of both."""
    count = first.num + second.num
    share = jnp.where(count > 0, second.num / jnp.maximum(count, 1), 0.0)
    gap = second.mean - first.mean
    return Statistics(
        num=count,
        mean=first.mean + share * gap,
        squares=first.squares + second.squares + first.num * share * gap**2,
    )


def merge_all(parts: Statistics) -> Statistics:
    """Returns the statistics of all parts, which are along a first axis, as of a population."""
    count = jnp.sum(parts.num)
    shares = parts.num / jnp.maximum(count, 1)
    mean = shares @ parts.mean
    between = parts.num @ (parts.mean - mean) ** 2
    return Statistics(count, mean, jnp.sum(parts.squares, axis=0) + between)


def deviations(statistics: Statistics) -> Float[Array, " obs"]:
    """Returns standard deviations; 1 where there is nothing to tell them from."""
    variance = statistics.squares / jnp.maximum(statistics.num, 1)
    deviation = jnp.sqrt(variance)
    return jnp.where(deviation > SMALLEST_DEVIATION, deviation, 1.0)


def whiten(statistics: Statistics, observation: Float[Array, " obs"]) -> Float[Array, " obs"]:
    """Returns an observation as policies of version 2 see it."""
    return (observation - statistics.mean) / deviations(statistics)


def fold_in(
    statistics: Statistics, weights: Float[Array, "act obs"]
) -> tuple[Float[Array, "act obs"], Float[Array, " act"]]:
    """Returns weights and bias of the linear policy that does the same with raw observations."""
    raw = weights / deviations(statistics)
    return raw, -raw @ statistics.mean


class ObservingState(NamedTuple):
    """State of a strategy whose policies see whitened observations.

    Attributes:
      inner: the strategy's own state.
      statistics: of all observations told, to whiten those of the population asked for.
    """

    inner: Any
    statistics: Statistics


@runtime_checkable
class TellObserved(Protocol):
    """Takes in the fitness, and what was observed on the way."""

    def __call__(
        self,
        key: PRNGKeyArray,
        population: Population,
        fitness: Float[Array, " pop"],
        observed: Statistics,
        state: ObservingState,
        /,
    ) -> tuple[ObservingState, Any]:
        """Returns the next state and the strategy's metrics; uses up `key`.

        Args:
          key: random key, different from the one `ask` had.
          population: genotypes from `ask`, in the same order.
          fitness: one value a genotype, higher is better, NaN is worst.
          observed: of all rollouts of this population; see `merge_all`.
          state: state from `ask`.
        """
        ...


@runtime_checkable
class InitObserving(Protocol):
    """Makes the state of generation 0."""

    def __call__(self, key: PRNGKeyArray, template: Genotype, /) -> ObservingState:
        """Returns the state before anything is evaluated; uses up `key`."""
        ...


@dataclasses.dataclass(frozen=True, kw_only=True)
class ObservingStrategy:
    """A strategy for policies that whiten what they observe.

    Attributes:
      population_size: genotypes in a generation.
      init: makes the first state.
      ask: gives the population to evaluate; its policies `whiten` by the state's statistics.
      tell_observed: turns population, fitness and observations into the next state.
    """

    population_size: int
    init: InitObserving
    ask: Ask[ObservingState]
    tell_observed: TellObserved


def with_observations(strategy: Strategy[Any, Any], *, num_observed: int) -> ObservingStrategy:
    """Returns the strategy with statistics of observations beside it: around `ars`, its V2.

    Args:
      strategy: any.
      num_observed: numbers in an observation.
    """

    def init(key: PRNGKeyArray, template: Genotype) -> ObservingState:
        return ObservingState(strategy.init(key, template), nothing(num_observed))

    def ask(key: PRNGKeyArray, state: ObservingState) -> tuple[Population, ObservingState]:
        population, inner = strategy.ask(key, state.inner)
        return population, state._replace(inner=inner)

    def tell_observed(
        key: PRNGKeyArray,
        population: Population,
        fitness: Float[Array, " pop"],
        observed: Statistics,
        state: ObservingState,
    ) -> tuple[ObservingState, Any]:
        inner, metrics = strategy.tell(key, population, fitness, state.inner)
        return ObservingState(inner, merge(state.statistics, observed)), metrics

    return ObservingStrategy(
        population_size=strategy.population_size, init=init, ask=ask, tell_observed=tell_observed
    )
