"""Experiments that walk nowhere: their genotypes are fitted to something, and judged once."""

from typing import Any, Protocol, runtime_checkable


@runtime_checkable
class Fitting(Protocol):
    """An experiment without trials, beside what else the evolution needs of one.

    Fitness is minus an error, and the same whenever it is measured.
    """

    @property
    def unit(self) -> str:
        """Of the error."""
        ...

    @property
    def save_every(self) -> int:
        """Generations from one checkpoint to the next, which may take longer than they do."""
        ...

    def describe(self) -> str:
        """Returns what is fitted to what, in a few words."""
        ...

    def judge(self, genotype: Any, /) -> dict[str, float]:
        """Returns the figures of a champion, by name."""
        ...
