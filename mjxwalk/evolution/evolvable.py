"""What the loop needs of an experiment, and of what runs its trials."""

from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, PRNGKeyArray

from mjxwalk.errors import RunError
from mjxwalk.evolution import memory
from mjxwalk.experiments.goal import Goal
from mjxwalk.rollout import TrialRunner
from mjxwalk.strategies import Strategy


@runtime_checkable
class Evolvable(Protocol):
    """What can be evolved: an `Experiment`, or as much of one as the loop needs."""

    @property
    def generations(self) -> int:
        """How many of them."""
        ...

    @property
    def terrains_per_evaluation(self) -> int:
        """Trials of each genotype, each on a terrain of its own."""
        ...

    @property
    def goal(self) -> Goal:
        """What ends the evolution earlier."""
        ...

    @property
    def weight(self) -> float:
        """Body weight, N."""
        ...

    @property
    def start(self) -> str:
        """What the evolution starts from: "zero", "winner", "mean" or "population"."""
        ...

    def template(self) -> Any:
        """Returns the genotype that generation 0 is drawn around."""
        ...

    def make_strategy(self) -> Strategy[Any, Any]:
        """Returns what turns a population and its fitness into the next population."""
        ...

    def take_over(self, strategy: Any, state: Any, before: Any, elite_fitness: Any) -> Any:
        """Returns a strategy's state with that of a population evolved before put in.

        Args:
          strategy: from `make_strategy`.
          state: of it, as `init` made it.
          before: arrays of the state to put in, by name.
          elite_fitness: of that population's last generations, newest last.

        Raises:
          RunError: the arrays do not fit.
        """
        ...

    def first_roughness(self) -> float:
        """Returns the roughness of generation 1, m."""
        ...

    def next_roughness(self, roughness: float, distance: Float[np.ndarray, " pop"]) -> float:
        """Returns the roughness of the generation after one of that roughness and distance, m."""
        ...

    def sample_trials(self, key: PRNGKeyArray, num: int, roughness: float | None = None) -> Any:
        """Returns trials; without a roughness those that count in the end."""
        ...


def check(experiment: Any) -> None:
    """Raises RunError unless an `Evolvable` fits into memory, and its strategy can be made."""
    memory.check_settings(experiment)
    try:
        experiment.make_strategy()  # checks its options, which a file may have any in
    except (ValueError, TypeError, OverflowError) as error:
        raise RunError(str(error)) from None


@runtime_checkable
class Evaluator(TrialRunner, Protocol):
    """Runs the trials of a population, and compiles for them beforehand."""

    @property
    def compile_s(self) -> float:
        """Seconds spent compiling so far."""
        ...

    def prepare(self, population: Any, trials: Any, /) -> None:
        """Compiles for arguments of these shapes, which may be all that they have."""
        ...
