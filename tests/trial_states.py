"""States of walkers in the middle of a trial."""

from typing import Any

from mjxwalk.envs import State


def counted(state: State, **counts: Any) -> State:
    """Returns a state with other counts in its trial."""
    return state._replace(trial=state.trial._replace(**counts))
