"""Islands: populations that evolve side by side and now and then exchange their best.

Whitley, Rana & Heckendorn (1999), "The island model genetic algorithm: on separability, population
size and convergence", Journal of Computing and Information Technology 7(1):33-47: migration in a
ring.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax.sharding import Mesh, NamedSharding, PartitionSpec
from jaxtyping import Array, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks
from mjxwalk.strategies.base import Genotype, Population, Strategy, Tree
from mjxwalk.strategies.metrics import FitnessMetrics, summarise_fitness
from mjxwalk.strategies.operators import best_first, take


class IslandsState(NamedTuple):
    """State of strategies that evolve side by side.

    Attributes:
      inner: the strategy's own states, with an axis of islands in front.
      generation: number of the generation to be evaluated next.
    """

    inner: Any
    generation: Int[Array, ""]


def with_islands(
    strategy: Strategy[Any, Any],
    *,
    num_islands: int,
    every: int,
    num_migrants: int,
    mesh: Mesh | None = None,
) -> Strategy[IslandsState, FitnessMetrics]:
    """Returns so many of a strategy, each with a population of its own, that exchange genotypes.

    A migrant is told to the next island, with its fitness, in place of that island's worst
    genotype. The population handed out is that of all islands, one after the other.

    Args:
      strategy: of one island. What its state holds beside a genotype, as masks and learning rates
        of a self-adaptive algorithm, does not migrate.
      num_islands: how many.
      every: generations from one migration to the next.
      num_migrants: best genotypes that go on to the next island; fewer than its population.
      mesh: devices with one axis, over which the islands are spread; None to leave that to the
        caller.

    Raises:
      ValueError: a setting is out of its range, or the islands cannot be spread evenly.
    """
    checks.check_count("num_islands", num_islands, minimum=1)
    checks.check_count("every", every, minimum=1)
    size = strategy.population_size
    checks.check_count("num_migrants", num_migrants, minimum=0, maximum=size - 1)
    if mesh is not None and num_islands % mesh.size:
        raise ValueError(
            f"num_islands must be a multiple of the mesh's {mesh.size} devices, got {num_islands}"
        )

    def spread(tree: Tree) -> Tree:
        if mesh is None:
            return tree
        sharding = NamedSharding(mesh, PartitionSpec(mesh.axis_names[0]))
        return jax.tree.map(lambda leaf: jax.lax.with_sharding_constraint(leaf, sharding), tree)

    def init(key: PRNGKeyArray, template: Genotype) -> IslandsState:
        keys = jax.random.split(key, num_islands)
        inner = jax.vmap(strategy.init, in_axes=(0, None))(keys, template)
        return IslandsState(spread(inner), jnp.zeros((), jnp.int32))

    def ask(key: PRNGKeyArray, state: IslandsState) -> tuple[Population, IslandsState]:
        population, inner = jax.vmap(strategy.ask)(jax.random.split(key, num_islands), state.inner)
        together = jax.tree.map(lambda leaf: leaf.reshape(-1, *leaf.shape[2:]), population)
        return spread(together), state._replace(inner=spread(inner))

    def tell(
        key: PRNGKeyArray,
        population: Population,
        fitness: Float[Array, " pop"],
        state: IslandsState,
    ) -> tuple[IslandsState, FitnessMetrics]:
        apart = jax.tree.map(
            lambda leaf: leaf.reshape(num_islands, size, *leaf.shape[1:]), population
        )
        told = (spread(apart), spread(fitness.reshape(num_islands, size)))
        if num_migrants:
            is_due = (state.generation + 1) % every == 0
            moved = migrate(*told, num_migrants)
            told = jax.tree.map(lambda new, old: jnp.where(is_due, new, old), moved, told)
        keys = jax.random.split(key, num_islands)
        inner, _ = jax.vmap(strategy.tell)(keys, told[0], told[1], state.inner)
        new_state = IslandsState(spread(inner), state.generation + 1)
        return new_state, FitnessMetrics(summarise_fitness(fitness))

    return Strategy(population_size=num_islands * size, init=init, ask=ask, tell=tell)


def migrate(
    populations: Tree, fitness: Float[Array, "island pop"], num_migrants: int
) -> tuple[Tree, Float[Array, "island pop"]]:
    """Returns islands in which the best of the one before stand in the places of the worst.

    Args:
      populations: genotypes with axes of islands and of each island's population in front.
      fitness: of them.
      num_migrants: how many move.
    """
    order = jax.vmap(best_first)(fitness)
    best, worst = order[:, :num_migrants], order[:, -num_migrants:]

    def move(leaf: Array) -> Array:
        arriving = jnp.roll(jax.vmap(take)(leaf, best), 1, axis=0)
        return jax.vmap(lambda rows, place, new: rows.at[place].set(new))(leaf, worst, arriving)

    return jax.tree.map(move, populations), move(fitness)
