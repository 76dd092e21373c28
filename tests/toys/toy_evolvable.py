"""A user's experiment that is no `Experiment`: numbers that have to become 1."""

import dataclasses
from typing import Any

import jax.numpy as jnp

from mjxwalk import runs, strategies
from mjxwalk.envs import Trials
from mjxwalk.experiments.goal import Goal
from mjxwalk.rollout import Outcome


@dataclasses.dataclass(frozen=True, kw_only=True)
class Point:
    """Has as much of an experiment as the loop needs."""

    name: str = "point"
    generations: int = 2
    population_size: int = 8
    terrains_per_evaluation: int = 1
    goal: Goal = Goal()
    start: str = "zero"
    sigma: float = 0.5

    @property
    def weight(self) -> float:
        """Body weight, N."""
        return 1.0

    def template(self) -> Any:
        """Returns zeros."""
        return {"numbers": jnp.zeros(3)}

    def make_strategy(self) -> Any:
        """Returns the strategy."""
        return strategies.make("snes", population_size=self.population_size, sigma=self.sigma)

    def take_over(self, strategy: Any, state: Any, before: Any, elite_fitness: Any) -> Any:
        """Returns the strategy's state with another put in."""
        return runs.unflatten(state, before)

    def first_roughness(self) -> float:
        """Returns 0."""
        return 0.0

    def next_roughness(self, roughness: float, distance: Any) -> float:
        """Returns 0."""
        return 0.0

    def sample_trials(self, key: Any, num: int, roughness: float | None = None) -> Trials:
        """Returns trials that are all the same."""
        return Trials(jnp.zeros((num, 1)))

    def as_tested(self) -> "Point":
        """Returns itself."""
        return self

    def rollout(self, genotype: Any, given: Any) -> Outcome:
        """Returns how far the numbers are from 1."""
        off = jnp.sum((genotype["numbers"] - 1.0) ** 2)
        no, zero = jnp.zeros((), bool), jnp.zeros(())
        return Outcome(-off, -off, zero + 1.0, no, no, zero, zero, jnp.ones((), jnp.int32))


TASK = Point()
