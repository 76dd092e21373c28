"""What shows a run while it goes on."""

from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from mjxwalk.experiments.run_config import Config
from mjxwalk.runs import Metrics, Result


@runtime_checkable
class Progress(Protocol):
    """Shows a run."""

    def start(self, path: Path, config: Config, evaluator: Any, /) -> None:
        """Shows what is about to run."""
        ...

    def generation(self, line: Metrics, /) -> None:
        """Shows a generation that has been evaluated."""
        ...

    def say(self, text: str, /) -> None:
        """Shows a sentence."""
        ...

    def close(self) -> None:
        """Gives the terminal back; may be called again."""
        ...

    def finish(self, path: Path, config: Config, result: Result, /) -> None:
        """Shows what was evolved, where it is, and what to type next."""
        ...
