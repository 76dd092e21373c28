"""Strategies of evosax as ours, and ours as algorithms of evosax.

evosax (Lange 2022, https://arxiv.org/abs/2212.04180, version 0.3) minimises fitness, is made for
one solution, and takes its hyper-parameters with every call. It is not imported here.
"""

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from mjxwalk.strategies import checks, draws, edge
from mjxwalk.strategies.base import Genotype, Population, Strategy, Tree
from mjxwalk.strategies.metrics import FitnessMetrics, summarise_fitness


class FromEvosaxState(NamedTuple):
    """State of an algorithm of evosax.

    Attributes:
      inner: its own.
      first: population of generation 0, of an algorithm that starts from one; else None.
      has_begun: whether that has been told.
    """

    inner: Any
    first: Tree
    has_begun: Bool[Array, ""]


def from_evosax(
    algorithm: Any, params: Any = None, *, initial_sigma: float | int | None = None
) -> Strategy[FromEvosaxState, FitnessMetrics]:
    """Returns an algorithm of evosax as a strategy.

    Args:
      algorithm: instance, made with a solution of the template's structure, shapes and dtypes.
      params: its hyper-parameters; None for its defaults.
      initial_sigma: standard deviation of generation 0 about the template, for an algorithm that
        starts from an evaluated population; others have a parameter for that.

    Raises:
      ValueError: initial_sigma is missing or out of its range, or, from `init`, the template is not
        like the algorithm's solution.
    """
    params = algorithm.default_params if params is None else params
    size = int(algorithm.population_size)
    is_population_based = hasattr(algorithm, "get_population")
    if is_population_based:
        checks.check_numbers("initial_sigma", initial_sigma, minimum=0.0)
    elif initial_sigma is not None:
        raise ValueError(
            f"initial_sigma is for algorithms that start from a population, got {initial_sigma} "
            f"for {type(algorithm).__name__}"
        )

    def init(key: PRNGKeyArray, template: Genotype) -> FromEvosaxState:
        _check_like(algorithm.solution, template)
        has_begun = jnp.asarray(not is_population_based)
        if not is_population_based:
            return FromEvosaxState(_strong(algorithm.init(key, template, params)), None, has_begun)
        key_noise, key_init = jax.random.split(key)
        everyone = jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, (size, *leaf.shape)), template)
        noise = draws.normal_like(key_noise, everyone)
        first = jax.tree.map(
            lambda w, z: w + jnp.asarray(initial_sigma, w.dtype) * z, everyone, noise
        )
        inner = algorithm.init(key_init, first, jnp.full(size, jnp.inf), params)
        return FromEvosaxState(_strong(inner), first, has_begun)

    def ask(key: PRNGKeyArray, state: FromEvosaxState) -> tuple[Population, FromEvosaxState]:
        population, inner = algorithm.ask(key, state.inner, params)
        if state.first is not None:
            population = jax.tree.map(
                lambda later, first: jnp.where(state.has_begun, later, first),
                population,
                state.first,
            )
        # With its constants in double precision evosax would hand out that too.
        population = jax.tree.map(
            lambda leaf, like: leaf.astype(jnp.result_type(like)), population, algorithm.solution
        )
        return population, state._replace(inner=_strong(inner))

    def tell(
        key: PRNGKeyArray,
        population: Population,
        fitness: Float[Array, " pop"],
        state: FromEvosaxState,
    ) -> tuple[FromEvosaxState, FitnessMetrics]:
        cost = jnp.where(jnp.isnan(fitness), jnp.inf, -fitness)
        key_tell, key_init = jax.random.split(key)
        inner, _ = algorithm.tell(key_tell, population, cost, state.inner, params)
        if is_population_based:
            start = algorithm.init(key_init, population, cost, params)
            inner = jax.tree.map(
                lambda later, first: jnp.where(state.has_begun, later, first), inner, start
            )
        new_state = state._replace(inner=_strong(inner), has_begun=jnp.ones((), bool))
        return new_state, FitnessMetrics(summarise_fitness(fitness))

    return Strategy(population_size=size, init=init, ask=ask, tell=tell)


class ToEvosaxState(NamedTuple):
    """State of one of our strategies as evosax has it.

    Attributes:
      inner: the strategy's own.
      best_solution: of lowest fitness so far; the solution itself before the first.
      best_fitness: its fitness; infinity before the first.
      generation_counter: generations told.
    """

    inner: Any
    best_solution: Genotype
    best_fitness: Float[Array, ""]
    generation_counter: Int[Array, ""]


@dataclasses.dataclass(frozen=True, kw_only=True)
class EvosaxAlgorithm:
    """What evosax calls an algorithm: it minimises, and its methods take parameters, here None.

    Attributes:
      strategy: one of ours.
      solution: template of the genotypes.
      default_params: None.
    """

    strategy: Strategy[Any, Any]
    solution: Genotype
    default_params: None = None

    @property
    def population_size(self) -> int:
        """Solutions in a generation."""
        return self.strategy.population_size

    @property
    def num_dims(self) -> int:
        """Weights of a solution."""
        return sum(leaf.size for leaf in jax.tree.leaves(self.solution))

    def init(self, key: PRNGKeyArray, mean: Any, params: None = None) -> ToEvosaxState:
        """Returns the state before anything is evaluated."""
        del params
        mean = edge.as_template(mean)
        return ToEvosaxState(
            inner=self.strategy.init(key, mean),
            best_solution=mean,
            best_fitness=jnp.full((), jnp.inf, float),
            generation_counter=jnp.zeros((), jnp.int32),
        )

    def ask(
        self, key: PRNGKeyArray, state: ToEvosaxState, params: None = None
    ) -> tuple[Population, ToEvosaxState]:
        """Returns the solutions to evaluate."""
        del params
        population, inner = self.strategy.ask(key, state.inner)
        return population, state._replace(inner=inner)

    def tell(
        self,
        key: PRNGKeyArray,
        population: Any,
        fitness: Any,
        state: ToEvosaxState,
        params: None = None,
    ) -> tuple[ToEvosaxState, dict[str, Any]]:
        """Returns the next state and figures; lower fitness is better, and NaN is worst."""
        del params
        asked = jax.jit(self.strategy.ask)
        key, population, fitness = edge.told(
            asked, self.population_size, key, population, fitness, state.inner
        )
        inner, _ = self.strategy.tell(key, population, -fitness, state.inner)
        cost = jnp.where(jnp.isnan(fitness), jnp.inf, fitness)
        place = jnp.argmin(cost)
        best_now = jax.tree.map(lambda leaf: leaf[place], population)
        is_better = cost[place] < state.best_fitness
        best_solution = jax.tree.map(
            lambda new, old: jnp.where(is_better, new, old), best_now, state.best_solution
        )
        best_fitness = jnp.minimum(cost[place], state.best_fitness).astype(float)
        metrics = {
            "generation_counter": state.generation_counter,
            "best_fitness_in_generation": cost[place],
            "best_solution_in_generation": best_now,
            "best_fitness": best_fitness,
            "best_solution": best_solution,
        }
        counted = state.generation_counter + 1
        return ToEvosaxState(inner, best_solution, best_fitness, counted), metrics


def to_evosax(strategy: Strategy[Any, Any], solution: Any) -> EvosaxAlgorithm:
    """Returns a strategy with the methods of an algorithm of evosax, for loops written for those.

    Args:
      strategy: any of ours; it goes on to maximise, as it is told fitness with its sign changed.
      solution: template of the genotypes.

    Raises:
      ValueError: the solution is no pytree of float arrays.
    """
    return EvosaxAlgorithm(strategy=strategy, solution=edge.as_template(solution))


def _strong(tree: Tree) -> Tree:
    # evosax starts some counts as Python numbers, which would change their type in a scan.
    return jax.tree.map(
        lambda leaf: jax.lax.convert_element_type(leaf, jnp.result_type(leaf)), tree
    )


def _check_like(solution: Tree, template: Genotype) -> None:
    shapes = [
        (jax.tree.structure(tree), [jnp.shape(leaf) for leaf in jax.tree.leaves(tree)])
        for tree in (solution, template)
    ]
    if shapes[0] != shapes[1]:
        raise ValueError(
            "template must be like the solution that the algorithm was made with, "
            f"{shapes[0][0]} of shapes {shapes[0][1]}, got {shapes[1][0]} of {shapes[1][1]}"
        )
