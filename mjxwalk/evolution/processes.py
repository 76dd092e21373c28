"""The processes that evolve one run: what they share, and what they decide together."""

from typing import Any

from mjxwalk.evolution.generation import RunState
from mjxwalk.experiments.run_config import Config


class Processes:
    """All processes of a run, as one of them sees them; here it is the only one."""

    @property
    def is_first(self) -> bool:
        """Whether this process writes the run."""
        return True

    def check_same(self, settings: Config) -> None:
        """Raises RunError unless all processes were given these settings."""

    def share(self, evaluator: Any) -> Any:
        """Returns an evaluator that leaves parts of a population to the other processes."""
        return evaluator

    def first_of(self, state: RunState) -> RunState:
        """Returns the state that the first process has."""
        return state

    def any_of(self, asked: bool) -> bool:
        """Returns whether any process is asked to stop, in all of them alike."""
        return asked
