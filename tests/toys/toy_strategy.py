"""A strategy of our own for the tests: it moves the best genotype so far a little."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from mjxwalk.strategies import Strategy


class State(NamedTuple):
    """The best genotype so far, and its fitness."""

    best: Any
    fitness: Float[Array, ""]


class Metrics(NamedTuple):
    """The best fitness so far."""

    best_fitness: Float[Array, ""]


def toy_hill_climber(*, population_size: int, sigma: float) -> Strategy[State, Metrics]:
    """Returns a climber that keeps its place in every generation."""

    def init(key: Any, template: Any) -> State:
        del key
        return State(template, jnp.float32(-jnp.inf))

    def ask(key: Any, state: State) -> tuple[Any, State]:
        leaves, tree = jax.tree.flatten(state.best)
        moved = [
            leaf + sigma * jax.random.normal(one, (population_size, *leaf.shape)).at[0].set(0.0)
            for one, leaf in zip(jax.random.split(key, len(leaves)), leaves, strict=True)
        ]
        return jax.tree.unflatten(tree, moved), state

    def tell(key: Any, population: Any, fitness: Any, state: State) -> tuple[State, Metrics]:
        del key
        place = jnp.argmax(jnp.where(jnp.isnan(fitness), -jnp.inf, fitness))
        better = fitness[place] > state.fitness
        best = jax.tree.map(
            lambda leaf, old: jnp.where(better, leaf[place], old), population, state.best
        )
        top = jnp.where(better, fitness[place], state.fitness)
        return State(best, top), Metrics(top)

    return Strategy(population_size=population_size, init=init, ask=ask, tell=tell)
