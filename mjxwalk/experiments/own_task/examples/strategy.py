"""A strategy of my own: a hill climber with a step that grows with success evolves a walker.

Evolve with `mjxwalk evolve FILE`; settings are changed by, say, `--set strategy.sigma=0.1`.
A strategy is three pure functions of a state, traced by JAX: use jax.numpy, keys in place of
Python's random numbers, and jnp.where in place of `if`.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk import strategies
from mjxwalk.controllers import LinearReactive
from mjxwalk.envs import Planar7, RandomWalk
from mjxwalk.experiments.experiment import Experiment, StrategyChoice


class State(NamedTuple):
    """All that the next generation needs: a checkpoint is this, and a random key."""

    best: Any  # a genotype
    fitness: Float[Array, ""]  # of the best
    sigma: Float[Array, ""]  # standard deviation of a step


class Metrics(NamedTuple):
    """Scalars that are kept for each generation."""

    sigma: Float[Array, ""]


def climber(
    *, population_size: int, sigma: float, growth: float = 1.2
) -> strategies.Strategy[State, Metrics]:
    """Returns the strategy.

    Args:
      population_size: genotypes in a generation.
      sigma: standard deviation of the first steps.
      growth: factor on it after a success; failures take a quarter of it back.

    Raises:
      ValueError: a setting is out of its range.
    """
    if sigma <= 0:
        raise ValueError(f"sigma must be above 0, got {sigma}")

    def init(key: Any, template: Any) -> State:
        return State(template, jnp.float32(-jnp.inf), jnp.float32(sigma))

    def ask(key: Any, state: State) -> tuple[Any, State]:
        """Returns the population: the genotype's leaves with an axis in front."""
        leaves, tree = jax.tree.flatten(state.best)
        keys = jax.random.split(key, len(leaves))
        moved = [
            leaf + state.sigma * jax.random.normal(one, (population_size, *leaf.shape))
            for one, leaf in zip(keys, leaves, strict=True)
        ]
        return jax.tree.unflatten(tree, moved), state

    def tell(key: Any, population: Any, fitness: Any, state: State) -> tuple[State, Metrics]:
        """Returns the next state; higher fitness is better, NaN is worst."""
        place = jnp.argmax(jnp.where(jnp.isnan(fitness), -jnp.inf, fitness))
        is_better = fitness[place] > state.fitness
        best = jax.tree.map(
            lambda new, old: jnp.where(is_better, new[place], old), population, state.best
        )
        factor = jnp.where(is_better, growth, growth**-0.25)
        top = jnp.maximum(fitness[place], state.fitness)
        return State(best, top, state.sigma * factor), Metrics(state.sigma)

    return strategies.Strategy(population_size=population_size, init=init, ask=ask, tell=tell)


strategies.register("my-climber", climber)

TASK = Experiment(
    name="climbing",
    env=Planar7(terrain=RandomWalk(roughness=0.004), max_time=10.0),
    controller=LinearReactive(links="local"),
    strategy=StrategyChoice(name="my-climber", options={"sigma": 0.3}),
    population_size=128,
    generations=50,
    terrains_per_evaluation=1,
)
