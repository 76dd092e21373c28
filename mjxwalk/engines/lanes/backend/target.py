"""What code is generated for."""

import dataclasses


@dataclasses.dataclass(frozen=True, kw_only=True)
class Target:
    """A processor and the width of its vectors.

    Attributes:
      width: lanes of a vector.
      processor: LLVM's name of the architecture.
      cpu, features: LLVM's names of the model and of what it can do.
      estimates: whether it has 14-bit estimates of 1/x and 1/sqrt(x) for this many floats.
    """

    width: int
    processor: str
    cpu: str
    features: str
    estimates: bool

    @property
    def registers(self) -> int:
        """How many vectors fit registers."""
        return 32 if self.width == 16 or self.processor.startswith(("aarch64", "arm64")) else 16

    @property
    def extremes_pass_nan(self) -> bool:
        """Whether it has instructions for `max` and `min` that pass NaN on."""
        return self.processor.startswith(("aarch64", "arm64", "nvptx"))
