"""What an evolution is made of."""

import dataclasses
from collections.abc import Mapping
from typing import Any

from jaxtyping import Array, Float, PRNGKeyArray

from mjxwalk import strategies
from mjxwalk.controllers import LinearReactive, Weights
from mjxwalk.controllers.linear_reactive import INPUTS, NETWORKS
from mjxwalk.envs import Planar7, Terrain
from mjxwalk.envs.checks import positive
from mjxwalk.evolution.goal import Goal
from mjxwalk.rollout import Outcome, rollout


@dataclasses.dataclass(frozen=True, kw_only=True)
class StrategyChoice:
    """A strategy by name, with its hyper-parameters.

    Attributes:
      name: as `strategies.make` knows it.
      options: hyper-parameters of its factory.
    """

    name: str
    options: Mapping[str, Any] = dataclasses.field(default_factory=dict[str, Any])


@dataclasses.dataclass(frozen=True, kw_only=True)
class Experiment:
    """A walker, its task, and how it evolves: all that is needed to repeat it but a seed.

    Attributes:
      name: as the command line knows it.
      env: body, ground and rules of a trial.
      controller: what the genotype becomes.
      strategy: what turns a population and its fitness into the next population.
      population_size: genotypes a generation.
      generations: how many of them.
      terrains_per_evaluation: trials of each genotype, each on a terrain of its own.
      goal: ends the evolution earlier, if there is one.
      restart_after: a population whose best fitness is below `restart_below` at that age starts
        anew, in generations; None for never.
      restart_below: see `restart_after`.
      restart_at: age at which every population starts anew, in generations; None for never. For
        evolutions with a goal: who has not reached it by then is slow.
    """

    name: str
    env: Planar7
    controller: LinearReactive
    strategy: StrategyChoice
    population_size: int
    generations: int
    terrains_per_evaluation: int
    goal: Goal = Goal()
    restart_after: int | None = None
    restart_below: float = 0.0
    restart_at: int | None = None

    def __post_init__(self) -> None:
        positive(self, "population_size", "generations", "terrains_per_evaluation")

    @property
    def weight(self) -> float:
        """Body weight, N."""
        return self.env.weight

    def template(self) -> Weights:
        """Returns the genotype that generation 0 is drawn around."""
        return self.controller.template()

    def make_strategy(self) -> strategies.Strategy[Any, Any]:
        """Returns the strategy, told which weights are links and which network each belongs to.

        Raises:
          ValueError: the strategy or one of its options does not exist, or has a wrong value.
        """
        strategy = strategies.make(
            self.strategy.name,
            population_size=self.population_size,
            mask=self.controller.mask(),
            groups=self.controller.networks(),
            **self.strategy.options,
        )
        if self.restart_after is None:
            return strategy
        return strategies.with_restarts(
            strategy,
            after=self.restart_after,
            below=self.restart_below,
            max_age=self.restart_at,
        )

    def sample_terrains(
        self, key: PRNGKeyArray, num: int, generation: int
    ) -> Float[Array, "terrain node"]:
        """Returns the terrains of a generation, heights in m."""
        del generation
        return self.env.terrain.sample(key, num)

    def rollout(self, genotype: Weights, terrain: Terrain) -> Outcome:
        """Returns what one walker does on one terrain."""
        return rollout(self.env, self.controller, genotype, terrain)

    def weight_table(self, genotype: Weights) -> list[tuple[str, str, str, float]]:
        """Returns a genotype as rows of weight set, network, input and value; links only."""
        links = self.controller.mask()
        rows: list[tuple[str, str, str, float]] = []
        for weight_set in ("initiation", "walking"):
            values, present = getattr(genotype, weight_set), getattr(links, weight_set)
            for i, network in enumerate(NETWORKS):
                for j, name in enumerate(INPUTS):
                    if present[i, j]:
                        rows.append((weight_set, network, name, float(values[i, j])))
        return rows
