"""What a kernel takes and gives back for one walker."""

import dataclasses

import numpy as np


@dataclasses.dataclass(frozen=True)
class Argument:
    """An input: one walker's shape and type, and whether all walkers share one.

    Attributes:
      generator: of random keys, whose words lie along the last axis; nothing for plain numbers.
    """

    shape: tuple[int, ...]
    dtype: str
    weak_type: bool
    shared: bool
    generator: str = ""

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return int(np.prod(self.shape, dtype=np.int64))


@dataclasses.dataclass(frozen=True)
class Result:
    """An output: one walker's shape and type."""

    shape: tuple[int, ...]
    dtype: str

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return int(np.prod(self.shape, dtype=np.int64))
