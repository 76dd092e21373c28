"""What shows a run while it goes on."""

from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from mjxwalk.experiments.run_config import Config
from mjxwalk.runs import Metrics, Result


@runtime_checkable
class Reporter(Protocol):
    """Shows how a run gets on."""

    def generation(self, line: Metrics, /) -> None:
        """Shows a generation that has been evaluated."""
        ...

    def say(self, text: str, /) -> None:
        """Shows a sentence that the user should know."""
        ...


@runtime_checkable
class Progress(Reporter, Protocol):
    """Shows a run from its start to its champion."""

    def start(self, path: Path, config: Config, evaluator: Any, /) -> None:
        """Shows what is about to run."""
        ...

    def close(self) -> None:
        """Gives the terminal back; may be called again."""
        ...

    def finish(self, path: Path, config: Config, result: Result, /) -> None:
        """Shows what was evolved, where it is, and what to type next."""
        ...
