"""What an evolution is made of."""

import dataclasses
from collections.abc import Mapping
from typing import Any, Literal

import jax
import numpy as np
from jaxtyping import Float, PRNGKeyArray

from mjxwalk import budget, strategies
from mjxwalk.controllers.controller import missing
from mjxwalk.envs import Trial, Trials, checks
from mjxwalk.experiments.goal import Goal
from mjxwalk.experiments.growth import Growth
from mjxwalk.experiments.pruning import Pruning
from mjxwalk.experiments.ramp import RoughnessRamp
from mjxwalk.experiments.rewiring import Rewiring
from mjxwalk.rollout import Environment, Outcome, rollout
from mjxwalk.runs import RunError, unflatten
from mjxwalk.settings import override

ENVIRONMENT = ("timestep", "sample_trials", "reset", "observe", "step", "fitness")


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
      start: what the evolution starts from: "zero" draws generation 0 around the controller's
        template; "winner" around the best walker of another run; "mean" around the mean of another
        run's last population; "population" goes on with that population and the state that its
        strategy was in.
      ramp: ground whose roughness changes as walkers get better; None for the same in all.
      test_settings: settings of `env`, by their paths, that differ where tournaments and reports
        test its walkers, such as {"terrain.roughness": 0.02}. Their actions have no noise there,
        unless it says so.
      pruning: removes links as the evolution goes on, and ends it when that has cost too much;
        None to keep them.
      rewiring: removes the weakest links and grows others; None to keep them.
      growth: evaluates as much of each population as its walkers' steps ask for; None to evaluate
        all of it.
    """

    name: str
    env: Any  # an `Environment`; the annotation of a setting must be a class or Any
    controller: Any  # a `Controller`
    strategy: StrategyChoice
    population_size: int
    generations: int
    terrains_per_evaluation: int
    goal: Goal = Goal()
    restart_after: int | None = None
    restart_below: float = 0.0
    restart_at: int | None = None
    start: Literal["zero", "winner", "mean", "population"] = "zero"
    ramp: RoughnessRamp | None = None
    # A table cannot be hashed; experiments that differ in it alone may share a hash.
    test_settings: Mapping[str, float] = dataclasses.field(
        default_factory=dict[str, float], hash=False
    )
    pruning: Pruning | None = None
    rewiring: Rewiring | None = None
    growth: Growth | None = None

    def __post_init__(self) -> None:
        checks.count(self, "population_size", "generations", "terrains_per_evaluation")
        if self.start not in ("zero", "winner", "mean", "population"):
            raise ValueError(f"start must be zero, winner, mean or population, got {self.start!r}")
        if self.restart_after is not None and (
            self.pruning or self.rewiring or self.start == "population"
        ):
            raise ValueError(
                "restart_after must be null where links are pruned or rewired or start is "
                "population: a restart would lose what was evolved before, got "
                f"{self.restart_after}"
            )
        if self.pruning and self.rewiring:
            raise ValueError("pruning and rewiring exclude each other; set one of them to null")
        if self.growth and (self.pruning or self.rewiring or self.restart_after is not None):
            raise ValueError(
                "growth excludes pruning, rewiring and restart_after, which follow each genotype "
                "of a population; set growth to null, or them"
            )
        if not isinstance(self.env, Environment):
            raise ValueError(
                f"env must have {', '.join(ENVIRONMENT)}, as a LeggedEnv has, got "
                f"{type(self.env).__name__}"
            )
        lacks = missing(self.controller)
        if lacks:
            raise ValueError(
                f"controller {type(self.controller).__name__} has no {', '.join(lacks)}; derive it "
                "from mjxwalk.controllers.Controller, which has all but template and act"
            )
        # A policy names the senses and motors of its body, so that a run says what they are.
        object.__setattr__(self, "controller", self.controller.on(self.env))
        self._tested_env()
        if self.goal.is_fine:
            self.finer(self.goal.fine_factor)  # refuses too short a step

    def _tested_env(self) -> Any:
        env = self.env
        for path, value in self.test_settings.items():
            try:
                env = override(env, path, str(value))
            except RunError as error:
                raise ValueError(f"test_settings: {error}") from None
        if getattr(env, "action_noise", 0.0) and "action_noise" not in self.test_settings:
            env = dataclasses.replace(env, action_noise=0.0)
        return env

    @property
    def weight(self) -> float:
        """Body weight, N; 1 of an environment that tells none."""
        return getattr(self.env, "weight", 1.0)

    def template(self) -> Any:
        """Returns the genotype that generation 0 is drawn around."""
        return self.controller.template()

    def make_strategy(self) -> strategies.Strategy[Any, Any]:
        """Returns the strategy, told which weights are links and which network each belongs to.

        Raises:
          ValueError: the strategy or one of its options does not exist, or has a wrong value; or
            the population cannot grow as it should; or links are to come and go, and the controller
            has none.
        """
        if self.growth is not None:
            self.growth.check(self.strategy.name, self.population_size)
        # Where links come and go, all weights of a link are to be inherited together.
        has_links = self.pruning is not None or self.rewiring is not None
        links = {"links": self._links()} if has_links else {}
        layers = {"groups": self.controller.networks()}
        strategy = strategies.make(
            self.strategy.name,
            population_size=self.population_size,
            mask=self.controller.mask(),
            **layers,
            **links,
            **self.strategy.options,
        )
        if self.pruning is not None:
            return strategies.with_pruning(strategy, **links, **dataclasses.asdict(self.pruning))
        if self.rewiring is not None:
            settings = dataclasses.asdict(self.rewiring)
            return strategies.with_rewiring(strategy, **links, **layers, **settings)
        if self.restart_after is None:
            return strategy
        return strategies.with_restarts(
            strategy,
            after=self.restart_after,
            below=self.restart_below,
            max_age=self.restart_at,
        )

    def _links(self) -> Any:
        links = self.controller.prunable()
        if all(np.all(np.asarray(leaf) < 0) for leaf in jax.tree.leaves(links)):
            what = "pruning" if self.pruning is not None else "rewiring"
            raise ValueError(
                f"{what} must be null, as {type(self.controller).__name__} has no links between "
                "units that could go"
            )
        return links

    def take_over(
        self,
        strategy: strategies.Strategy[Any, Any],
        state: Any,
        before: Mapping[str, Any],
        elite_fitness: Any,
    ) -> Any:
        """Returns a strategy's state with that of a population evolved before put in.

        Args:
          strategy: from `make_strategy`.
          state: of it, as `init` made it.
          before: arrays of the state to put in, by name.
          elite_fitness: of that population's last generations, newest last; pruning compares with
            them.

        Raises:
          RunError: the arrays do not fit.
        """
        if self.pruning is None:
            return _put_innermost(state, before)
        pruner: Any = strategy
        masked = isinstance(state.inner, strategies.EvolvingMasksState)
        own = state.inner.inner if masked else state.inner
        return jax.jit(pruner.begin)(_put_innermost(own, before), elite_fitness)

    def first_roughness(self) -> float:
        """Returns the roughness of generation 1, m."""
        return self._roughness if self.ramp is None else self.ramp.start

    def next_roughness(self, roughness: float, distance: Float[np.ndarray, " pop"]) -> float:
        """Returns the roughness of the generation after one of that roughness and distance, m."""
        if self.ramp is None:
            return roughness
        return self.ramp.after(roughness, distance, self._roughness)

    @property
    def _roughness(self) -> float:
        return getattr(getattr(self.env, "terrain", None), "roughness", 0.0)

    def sample_trials(self, key: PRNGKeyArray, num: int, roughness: float | None = None) -> Trials:
        """Returns trials; on ground of the environment's own roughness if none is given, m.

        Raises:
          RunError: they do not fit into memory.
        """
        budget.check_grounds(self.env, num)
        return self.env.sample_trials(key, num, roughness)

    def as_tested(self) -> "Experiment":
        """Returns the experiment as tournaments and reports test its walkers."""
        env = self._tested_env()
        if not self.test_settings:
            return self if env is self.env else dataclasses.replace(self, env=env)
        return dataclasses.replace(self, env=env, test_settings={}, ramp=None)

    def finer(self, factor: int) -> "Experiment":
        """Returns the experiment with its time step divided by a factor."""
        env = dataclasses.replace(self.env, timestep=self.env.timestep / factor)
        goal = dataclasses.replace(self.goal, fine_trials=0)  # which are these
        return dataclasses.replace(self, env=env, goal=goal)

    def rollout(self, genotype: Any, given: Trial) -> Outcome:
        """Returns what one walker does in one trial."""
        return rollout(self.env, self.controller, genotype, given)

    def weight_table(self, genotype: Any) -> list[tuple[str, str, str, float]]:
        """Returns a genotype as rows of weight set, network, input and value; links only."""
        return self.controller.weight_table(genotype)


def _put_innermost(state: Any, before: Mapping[str, Any]) -> Any:
    """Returns a state with arrays by name in place of the strategy's own, whatever is around it."""
    if hasattr(state, "inner"):
        return state._replace(inner=_put_innermost(state.inner, before))
    return unflatten(state, before)
